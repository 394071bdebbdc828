"""A played map as the record that the page reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from reports.score.robustness import GOALS
from reports.stress.records import (
    AxisRecord,
    CaseRecord,
    CellRecord,
    EpisodeKey,
    MapRecord,
    OccludedRecord,
)
from scenarios.spec.parameters.file import contents
from scenarios.spec.parameters.numeric import Numeric
from scenarios.stress.case import Case, Fidelity, TrialResult
from scenarios.stress.map.explore import MapPlan, PlayedCell, axes_of
from scenarios.stress.space import Axis, Space

MOST_HIDDEN = 30  # frames; longer ones count as these


def map_record(
    space: Space,
    plan: MapPlan,
    fidelity: Fidelity,
    cells: Sequence[PlayedCell],
    runs: int,
    episodes: Mapping[int, EpisodeKey],
    commands: Mapping[int, str],
    command: str,
) -> MapRecord:
    """The record of a map. episodes, commands: where the shown trials of cells
    are kept and what plays them again, by the cells' places.
    """
    x, y = axes_of(space, plan)
    results = [result for cell in cells for result in cell.results]
    return MapRecord(
        family=space.family.name,
        fidelity=fidelity,
        goal=plan.goal,
        level=plan.level,
        x=_axis(x),
        y=None if y is None else _axis(y),
        seeds=plan.seeds,
        others=plan.others,
        runs=runs,
        unplayed=sum(result.robustness is None for result in results),
        cells=tuple(
            CellRecord(
                x=cell.cell.x,
                y=cell.cell.y,
                n=cell.played,
                failures={goal: cell.failures(goal) for goal in GOALS},
                case=case_record(cell.cases[cell.shown(plan.goal)]),
                episode=episodes.get(place),
                command=commands.get(place, ""),
            )
            for place, cell in enumerate(cells)
        ),
        occluded=() if "fps" in (plan.x, plan.y) else occluded(results),
        command=command,
    )


def case_record(case: Case) -> CaseRecord:
    """The record of a case; a file by its content."""
    return CaseRecord(family=case.family, values=dict(contents(case.values)), seed=case.seed)


def occluded(results: Sequence[TrialResult]) -> tuple[OccludedRecord, ...]:
    """How often a target was lost, by the frames for which no view showed it."""
    found: dict[int, list[bool]] = {}
    for result in results:
        if result.robustness is not None:
            for hidden, rho in zip(result.occluded_frames, result.robustness.lost, strict=True):
                found.setdefault(min(hidden, MOST_HIDDEN), []).append(rho < 0)
    return tuple(
        OccludedRecord(frames=frames, n=len(lost), lost=sum(lost))
        for frames, lost in sorted(found.items())
    )


def _axis(axis: Axis) -> AxisRecord:
    unit = axis.parameter.unit if isinstance(axis.parameter, Numeric) else ""
    return AxisRecord(
        name=axis.name,
        unit=unit,
        low=axis.low,
        high=axis.high,
        log=axis.logarithmic,
        choices=axis.choices,
    )
