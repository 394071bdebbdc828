"""From the name of a scenario or suite to the scenarios to play, with the suite's values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pjpdaf.errors import NotComparable
from scenarios.play.job import Job, System, digest_of
from scenarios.spec.corpus_case import CorpusEntry
from scenarios.spec.draw import SETTINGS
from scenarios.spec.names import resolve, scenarios_of
from scenarios.spec.scenario import Scenario, in_varied_surroundings
from scenarios.spec.suite import Suite, SuiteEntry
from scenarios.spec.surroundings import VARIED
from sim.motion.stage import Value

SCENARIO_SEEDS = 10  # of a scenario that is named without a suite


@dataclass(frozen=True)
class PlannedScenario:
    """A scenario of a run: the values that its suite changes, and the number of seeds.

    first_seed: where its seeds start.
    """

    scenario: Scenario
    overrides: Mapping[str, Value]
    seeds: int
    label: str
    first_seed: int = 0

    @property
    def changeable(self) -> frozenset[str]:
        """Names that `--set` can change."""
        return frozenset((*self.scenario.parameters, *SETTINGS))

    def job(self, seed: int, system: System | None = None) -> Job:
        """The episode of a seed."""
        return Job(self.scenario, seed, self.overrides, system or System(), label=self.label)


def expand_target(target: str) -> list[PlannedScenario]:
    """Expand a target into the scenarios to play: a scenario, a suite, or a file of either.

    Raises BenchError; NotComparable for a corpus case whose scenario has changed.
    """
    named = resolve(target)
    if isinstance(named, Suite):
        refuse_changed(named)
        return expand_suite(named)
    planned = PlannedScenario(named, {}, SCENARIO_SEEDS, named.name)
    return [in_rooms(one, named.surroundings) for one in _at_rates(planned)]


def expand_suite(suite: Suite) -> list[PlannedScenario]:
    """The scenarios of a suite in its order. Raises BenchError for an unknown scenario."""
    return [
        in_rooms(planned, suite.surroundings)
        for entry, scenario in scenarios_of(suite)
        for planned in _at_rates(_planned(suite, entry, scenario))
    ]


def in_rooms(planned: PlannedScenario, surroundings: str) -> PlannedScenario:
    """The scenario in rooms of its label's own where it, or `surroundings`, is varied."""
    scenario = planned.scenario
    if scenario.rooms or VARIED not in (surroundings, scenario.surroundings):
        return planned
    return replace(planned, scenario=in_varied_surroundings(scenario, planned.label))


def _planned(suite: Suite, entry: SuiteEntry, scenario: Scenario) -> PlannedScenario:
    """An entry of a suite, before it is played at several rates."""
    return PlannedScenario(
        scenario,
        entry.overrides | ({} if entry.frames is None else {"frames": entry.frames}),
        entry.seeds or suite.seeds,
        entry.label or scenario.name,
        _first_seed(entry),
    )


def _first_seed(entry: SuiteEntry) -> int:
    return entry.first_seed if isinstance(entry, CorpusEntry) else 0


def refuse_changed(suite: Suite) -> None:
    """Raise NotComparable where a corpus case would no longer be the episode that failed."""
    for entry, scenario in scenarios_of(suite):
        if isinstance(entry, CorpusEntry):
            job = _planned(suite, entry, scenario).job(entry.first_seed)
            if digest_of(job) != entry.digest:
                raise NotComparable(
                    f"{entry.label}: not comparable: {entry.scenario} has changed since this case "
                    "was put into the corpus; search again, or remove the case"
                )


def _at_rates(planned: PlannedScenario) -> list[PlannedScenario]:
    """The scenario at each of its frame rates, over the same time; itself where it has none."""
    scenario = planned.scenario
    if not scenario.rates or "fps" in planned.overrides:
        return [planned]
    duration_s = float(planned.overrides.get("frames", scenario.frames)) / scenario.fps
    return [
        replace(
            planned,
            overrides={
                **planned.overrides,
                "fps": rate,
                "frames": max(1, round(duration_s * rate)),
            },
            label=f"{planned.label}@{rate:g}",
        )
        for rate in scenario.rates
    ]
