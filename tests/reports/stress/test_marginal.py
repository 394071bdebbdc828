"""A map of two parameters pooled over one of them."""

from itertools import product

import pytest

from reports.stress import records as r
from reports.stress.marginal import marginal


def cell(x, y, hits, n=8):
    case = r.CaseRecord(family="cross", values={"speed": 0.2}, seed=1)
    return r.CellRecord(x=x, y=y, n=n, failures={"swap": hits, "head": 0, "lost": 0}, case=case)


def map_of(cells):
    return r.MapRecord(
        family="cross",
        fidelity="fast",
        goal="swap",
        level=0.5,
        x=r.AxisRecord(name="speed", unit="m/s", low=0.1, high=0.6),
        y=r.AxisRecord(name="fps", unit="Hz", low=1.0, high=30.0, log=True),
        seeds=8,
        others="drawn",
        runs=8 * len(cells),
        cells=tuple(cells),
    )


@pytest.mark.parametrize("along", ["x", "y"])
def test_an_even_map_is_summed_along_the_other_axis(along):
    ends = [(i / 4, (i + 1) / 4) for i in range(4)]
    record = map_of([cell(x, y, n % 9) for n, (x, y) in enumerate(product(ends, ends))])
    pooled = marginal(record, along)
    assert (pooled.x, pooled.y) == (getattr(record, along), None)
    for part, at in zip(pooled.cells, ends, strict=True):
        mine = [c for c in record.cells if getattr(c, along) == at]
        assert (part.x, part.n) == (at, 32)
        assert part.failures["swap"] == sum(c.failures["swap"] for c in mine)


def test_a_split_cell_counts_by_its_area_and_an_empty_one_not_at_all():
    low, high, quarters = (0.0, 0.5), (0.5, 1.0), ((0.0, 0.25), (0.25, 0.5))
    cells = [cell(x, y, 8) for x, y in product(quarters, quarters)]
    cells += [cell(low, high, 0), cell(high, low, 8), cell(high, high, 0, n=0)]
    first, second = marginal(map_of(cells), "x").cells
    # The lower half fails always, the upper never: a half, although 32 of 40 trials failed.
    assert (first.failures["swap"], first.n) == (13, 26)  # of 25.6 equal trials
    assert (second.failures["swap"], second.n) == (8, 8)
