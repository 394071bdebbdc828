"""The cells of a map on a function whose contour is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from reports.score.robustness import Robustness
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.families import find_family
from scenarios.stress.map.cells import Cell, grid, on_contour, split
from scenarios.stress.map.explore import MapPlan, PlayedCell, explore
from scenarios.stress.space import Space

SPACE = Space.of(find_family("cross"))


def result(swapped: bool) -> TrialResult:
    rho = -1.0 if swapped else 1.0
    robustness = Robustness(rho, 1.0, 1.0, (0.5, 0.5, 0.5), (0.3, 0.3, 0.3), (-1,) * 6)
    return TrialResult("", robustness, frames=54, fps=3.0)


def swaps_above(limit: float) -> tuple[list[Case], object]:
    played: list[Case] = []

    def evaluate(cases: Sequence[Case]) -> list[TrialResult]:
        played.extend(cases)
        # Noise of the seed makes the limit soft.
        return [
            result(float(c.values["speed"]) + 0.02 * (c.seed % 100 / 50 - 1) > limit) for c in cases
        ]

    return played, evaluate


def area(cells: Sequence[PlayedCell]) -> float:
    return sum((c.cell.x[1] - c.cell.x[0]) * (c.cell.y[1] - c.cell.y[0]) for c in cells)


def test_the_contour_alone_is_refined_and_the_cells_tile_the_map() -> None:
    played, evaluate = swaps_above(0.3)
    cells, runs = explore(SPACE, MapPlan("speed", "depth_gap", cells=5, refine=2), evaluate)
    assert runs == len(played)
    assert area(cells) == pytest.approx(1.0)
    # Speed is searched by its logarithm.
    contour = np.log(0.3 / 0.1) / np.log(6)
    fine = [c for c in cells if c.cell.depth == 2]
    assert fine
    for cell in fine:
        assert abs(np.mean(cell.cell.x) - contour) < 0.2
    for cell in (c for c in cells if c.cell.depth == 0):
        # Soft by 0.02 m/s, a twentieth of the axis: no cell that was left is in doubt.
        assert cell.failures("swap") in (0, 1, 7, 8)


def test_every_cell_has_draws_of_its_own_and_the_same_again() -> None:
    plan = MapPlan("speed", cells=4, seeds=3, refine=0)
    first, evaluate = swaps_above(0.3)
    explore(SPACE, plan, evaluate)
    again, evaluate = swaps_above(0.3)
    explore(SPACE, plan, evaluate)
    assert first == again
    assert len({case.seed for case in first}) == 12
    assert len({case.values["hold"] for case in first}) == 12


def test_others_at_their_medians() -> None:
    played, evaluate = swaps_above(0.3)
    explore(SPACE, MapPlan("speed", cells=3, seeds=2, refine=0, others="medians"), evaluate)
    nominal = SPACE.nominal()
    for case in played:
        assert {n: v for n, v in case.values.items() if n != "speed"} == {
            n: v for n, v in nominal.items() if n != "speed"
        }


def test_a_choice_has_a_cell_for_each_and_is_not_split() -> None:
    x, y = SPACE.axis("speed"), SPACE.axis("front")
    cells = grid(x, y, 6)
    assert len(cells) == 12
    assert len(split(cells[0], x, y)) == 2
    assert split(cells[0], y, None) == [cells[0]]


def test_the_contour_is_in_doubt_or_between_neighbours() -> None:
    row = [Cell((i / 5, (i + 1) / 5), (0.0, 1.0)) for i in range(5)]
    assert on_contour(row, [(0, 8), (0, 8), (8, 8), (8, 8), (4, 8)], 0.5) == [
        *(False, True, True, False, True)
    ]
    corner = [Cell((0.0, 0.5), (0.0, 0.5)), Cell((0.5, 1.0), (0.5, 1.0))]
    assert on_contour(corner, [(0, 8), (8, 8)], 0.5) == [False, False]
    assert on_contour(row[:1], [(0, 0)], 0.5) == [True]


def test_the_shown_trial_is_a_failure_if_there_is_any() -> None:
    results = (result(False), result(True), result(True))
    cell = PlayedCell(Cell((0, 1), (0, 1)), (), results)
    assert cell.shown("swap") == 1
    assert PlayedCell(cell.cell, (), (TrialResult("", None), result(False))).shown("swap") == 1


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (MapPlan("speed", "speed"), "--x and --y are both speed"),
        (MapPlan("sped"), "cross has no parameter 'sped' to vary; did you mean speed?"),
        (MapPlan("speed", "hold", cells=60), "60 x 60 cells is too many; at most 2500 cells"),
        (MapPlan("speed", "hold", cells=50, seeds=100), "250000 runs; at most 200000"),
    ],
)
def test_plans_that_cannot_be_played(plan: MapPlan, message: str) -> None:
    _, evaluate = swaps_above(0.3)
    with pytest.raises(BenchError, match=message):
        explore(SPACE, plan, evaluate)
