"""The trials of a map: every cell's seeds, in rounds that refine the contour."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from pjpdaf.errors import BenchError
from reports.score.robustness import Goal, measures_of
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.estimate.outcomes import noise_seeds, normal_draws
from scenarios.stress.map.cells import MOST_RUNS, Cell, grid, on_contour, split
from scenarios.stress.space import Axis, Space

Evaluate = Callable[[Sequence[Case]], Sequence[TrialResult]]
Others = Literal["drawn", "medians"]
OTHERS: tuple[Others, ...] = get_args(Others)


@dataclass(frozen=True)
class MapPlan:
    """How to map. x, y: names of parameters; cells: along each axis at first; seeds: of a cell.

    refine: how often cells on the contour (P = level of the goal) are split; others: the other
    parameters are drawn nominally with each seed, or stay at their medians. seed: of all draws.
    """

    x: str
    y: str | None = None
    cells: int = 8
    seeds: int = 8
    refine: int = 1
    goal: Goal = "swap"
    level: float = 0.5
    others: Others = "drawn"
    seed: int = 0


@dataclass(frozen=True)
class PlayedCell:
    """A cell with its cases and their results."""

    cell: Cell
    cases: tuple[Case, ...]
    results: tuple[TrialResult, ...]

    @property
    def played(self) -> int:
        """Trials with a result; a draw that a person could not perform has none."""
        return sum(result.robustness is not None for result in self.results)

    def failures(self, goal: Goal) -> int:
        """Trials that failed."""
        names = measures_of((goal,))
        return sum(any(name in names for name in result.failed) for result in self.results)

    def shown(self, goal: Goal) -> int:
        """The trial that stands for it: the first that failed, with the goal if there is any."""
        names = measures_of((goal,))
        ranks = [
            (not any(n in names for n in r.failed), not r.failed, r.robustness is None)
            for r in self.results
        ]
        return ranks.index(min(ranks))


def explore(space: Space, plan: MapPlan, evaluate: Evaluate) -> tuple[list[PlayedCell], int]:
    """Play a map: its cells, from the bottom row up, and the number of all trials.

    Every cell has draws of its own, addressed by its place. Raises BenchError for a parameter that
    does not vary, the same parameter twice, too many cells; what `evaluate` raises.
    """
    x, y = axes_of(space, plan)
    waiting = grid(x, y, plan.cells)
    done: list[PlayedCell] = []
    runs = 0
    for left in range(plan.refine, -1, -1):
        check_runs(len(done) + len(waiting), plan)
        done += _play(space, plan, waiting, evaluate)
        runs += len(waiting) * plan.seeds
        tallies = [(cell.failures(plan.goal), cell.played) for cell in done]
        contour = on_contour([cell.cell for cell in done], tallies, plan.level)
        parts = [
            split(cell.cell, x, y) if crossed and left else [cell.cell]
            for cell, crossed in zip(done, contour, strict=True)
        ]
        done = [cell for cell, group in zip(done, parts, strict=True) if len(group) == 1]
        waiting = [part for group in parts if len(group) > 1 for part in group]
        if not waiting:
            break
    return sorted(done, key=lambda c: (c.cell.y, c.cell.x)), runs


def others_named(text: str) -> Others:
    """What the other parameters do. Raises BenchError."""
    for name in OTHERS:
        if text == name:
            return name
    raise BenchError(f"--others {text[:60]}: must be drawn or medians")


def axes_of(space: Space, plan: MapPlan) -> tuple[Axis, Axis | None]:
    """The axes of a map. Raises BenchError."""
    if plan.x == plan.y:
        raise BenchError(f"--x and --y are both {plan.x}; a map needs two parameters")
    return space.axis(plan.x), None if plan.y is None else space.axis(plan.y)


def check_runs(cells: int, plan: MapPlan) -> None:
    """Raise BenchError where so many cells are too many runs."""
    if cells * plan.seeds > MOST_RUNS:
        raise BenchError(
            f"{cells} cells with {plan.seeds} seeds are {cells * plan.seeds} runs; at most "
            f"{MOST_RUNS}"
        )


def _play(
    space: Space, plan: MapPlan, cells: Sequence[Cell], evaluate: Evaluate
) -> list[PlayedCell]:
    """Play all cells of a round at once, so that every worker has something to do."""
    cases = [_cases(space, plan, cell) for cell in cells]
    results = evaluate([case for group in cases for case in group])
    n = plan.seeds
    return [
        PlayedCell(cell, group, tuple(results[i * n : (i + 1) * n]))
        for i, (cell, group) in enumerate(zip(cells, cases, strict=True))
    ]


def _cases(space: Space, plan: MapPlan, cell: Cell) -> tuple[Case, ...]:
    x, y = axes_of(space, plan)
    at_x, at_y = cell.centre
    here = {x.name: x.of_unit(at_x)} | ({} if y is None else {y.name: y.of_unit(at_y)})
    stage = f"{space.family.name}/map/{cell.address}"
    if plan.others == "drawn":
        points = normal_draws(plan.seed, stage, plan.seeds, len(space.axes))
        values = [space.values_of_latent(z) for z in points]
    else:
        values = [space.nominal()] * plan.seeds
    seeds = noise_seeds(plan.seed, stage, plan.seeds).tolist()
    return tuple(
        Case(space.family.target, {**v, **here}, s) for v, s in zip(values, seeds, strict=True)
    )
