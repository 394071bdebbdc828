"""What a word of the command line plays: scenarios, with what a suite changes of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from scenarios.play.job import Job, System
from scenarios.spec.draw import SETTINGS
from scenarios.spec.names import resolve, scenarios_of
from scenarios.spec.scenario import Scenario
from scenarios.spec.suite import Suite
from sim.motion.stage import Value

SCENARIO_SEEDS = 10  # of a scenario that is named alone


@dataclass(frozen=True)
class PlannedScenario:
    """One scenario of a run: what a suite changes of it, and how many seeds it plays."""

    scenario: Scenario
    overrides: Mapping[str, Value]
    seeds: int
    label: str

    @property
    def changeable(self) -> frozenset[str]:
        """Names that `--set` can change."""
        return frozenset((*self.scenario.parameters, *SETTINGS))

    def job(self, seed: int, system: System | None = None) -> Job:
        """One episode of it, as the suite has it."""
        return Job(self.scenario, seed, self.overrides, system or System(), label=self.label)


def expand_target(target: str) -> list[PlannedScenario]:
    """Of a scenario, a suite, or a file of either. Raises BenchError."""
    found = resolve(target)
    if isinstance(found, Suite):
        return expand_suite(found)
    return _at_rates(PlannedScenario(found, {}, SCENARIO_SEEDS, found.name))


def expand_suite(suite: Suite) -> list[PlannedScenario]:
    """In the suite's order. Raises BenchError for an unknown scenario."""
    return [
        part
        for entry, scenario in scenarios_of(suite)
        for part in _at_rates(
            PlannedScenario(
                scenario,
                entry.overrides | ({} if entry.frames is None else {"frames": entry.frames}),
                entry.seeds or suite.seeds,
                entry.label or scenario.name,
            )
        )
    ]


def _at_rates(part: PlannedScenario) -> list[PlannedScenario]:
    """The same time at each of the scenario's frame rates; the part itself where it has none."""
    scenario = part.scenario
    if not scenario.rates or "fps" in part.overrides:
        return [part]
    duration_s = float(part.overrides.get("frames", scenario.frames)) / scenario.fps
    return [
        replace(
            part,
            overrides={**part.overrides, "fps": rate, "frames": max(1, round(duration_s * rate))},
            label=f"{part.label}@{rate:g}",
        )
        for rate in scenario.rates
    ]
