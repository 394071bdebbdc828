"""failures.json: the part of a search that the page shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from reports.score.robustness import GOALS, measures_of
from reports.stress.records import CaseRecord, ChangedValue, FailureRecord, Fidelity, SearchRecord
from scenarios.play.job import System
from scenarios.spec.corpus_case import numbered_label
from scenarios.spec.parameters.file import contents
from scenarios.spec.parameters.numeric import Numeric
from scenarios.stress.case import Trial
from scenarios.stress.confirm import Counterexample
from scenarios.stress.drawn import drawn_space
from scenarios.stress.families import find_family
from scenarios.stress.recording import Shown
from scenarios.stress.search.search import FamilySearch
from scenarios.stress.space import Space
from scenarios.stress.system_text import case_command, replay_command


def search_record(
    search: FamilySearch,
    found: Sequence[Counterexample],
    files: Sequence[Path | None],
    fidelity: Fidelity,
    shown: Mapping[int, Shown],
    system: System,
    fresh_runs: int = 0,
) -> SearchRecord:
    """A family's search; shown: by number, the failures whose episode the page plays.

    fresh_runs: of its budget, with fresh noise.
    """
    return SearchRecord(
        family=search.space.family.name,
        fidelity=fidelity,
        parameters=len(search.space.axes),
        runs=search.runs + fresh_runs,
        failing=sum(bool(e.result.failed) for e in search.evaluations),
        first=search.first_failure(),
        ended=search.ended,
        failures=tuple(
            _failure(one, search.space, fidelity, file, shown.get(number), system)
            for number, (one, file) in enumerate(zip(found, files, strict=True))
        ),
    )


def failure_name(one: Counterexample, number: int) -> str:
    """The name of a failure's case and episode."""
    return numbered_label(find_family(one.case.family).name, f"_{one.measure}_{number}")


def failure_command(
    one: Counterexample, file: Path | None, system: System, fidelity: Fidelity
) -> str:
    """The command that plays a failure again: its file, or all its values where it has none."""
    if file is not None:
        return case_command(file, one.case, system)
    return replay_command(Trial(one.case, system, fidelity if one.full is None else "full"))


def shown_failures(
    found: Sequence[Counterexample], system: System, fidelity: Fidelity
) -> dict[int, Shown]:
    """By number, the failures that count, as episodes for the page."""
    chosen: dict[int, Shown] = {}
    for number, one in enumerate(found):
        if one.counts:
            played = fidelity if one.full is None else "full"
            name = failure_name(one, number + 1)
            chosen[number] = Shown(name, Trial(one.case, system, played))
    return chosen


def _failure(
    one: Counterexample,
    space: Space,
    fidelity: Fidelity,
    file: Path | None,
    shown: Shown | None,
    system: System,
) -> FailureRecord:
    robustness = one.result.robustness
    assert robustness is not None
    signature = one.failure.signature
    varied = drawn_space(space) if signature.drawn else space
    nominal, values = varied.nominal(), one.failure.minimal.values
    return FailureRecord(
        measure=shown_measure(one),
        cell=one.failure.words,
        narrowed=one.failure.narrowed,
        case=CaseRecord(
            family=one.case.family, values=dict(contents(one.case.values)), seed=one.case.seed
        ),
        changed=tuple(
            ChangedValue(
                name=name,
                unit=_unit(varied, name),
                value=values[name],
                nominal=nominal[name],
                drawn=bool(signature.drawn),
            )
            for name, _ in signature.parts
        ),
        fidelity=fidelity if one.full is None else "full",
        rho=robustness.measures[shown_measure(one)],
        severity=one.result.severity,
        confirmed=None if one.full is None else one.confirmed,
        survived=(one.survival.failed, one.survival.of),
        blame=one.blame,
        command=failure_command(one, file, system, fidelity) if one.counts else "",
        episode=None if shown is None else shown.key,
    )


def shown_measure(one: Counterexample) -> str:
    """The measure that fails in the episode that counts: another hand's where that fails too."""
    if not one.confirmed or one.measure in one.result.failed:
        return one.measure
    goal = next(goal for goal in GOALS if one.measure in measures_of((goal,)))
    return next(name for name in one.result.failed if name in measures_of((goal,)))


def _unit(space: Space, name: str) -> str:
    parameter = space.axis(name).parameter
    return parameter.unit if isinstance(parameter, Numeric) else ""
