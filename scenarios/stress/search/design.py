"""The points of a search that no result has led to: corners, a Sobol sequence, and its edges."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import hadamard

from pjpdaf.arrays import Floats
from sim.randomness import generator

CORNERS = 16
SOBOL_LOG2 = 8  # 256 points, then as many more of another scrambling
AT_END = 0.9  # probability that a coordinate of an edge's point lies at an end of its axis


def corners(d: int, count: int = CORNERS) -> Floats:
    """Corners (count, d) of the unit cube that show every axis at both ends equally often.

    Rows of a Hadamard matrix: up to d = count - 1 any two axes meet in all four combinations
    (Plackett and Burman 1946); further axes repeat the columns.
    """
    signs = hadamard(count)[:, 1:]
    columns = np.arange(d) % (count - 1)
    return np.asarray((signs[:, columns] + 1) / 2, dtype=float)


def sobol(d: int, seed: int, stream: str) -> Iterator[Floats]:
    """Points (d,) of scrambled Sobol sequences without end."""
    from scipy.stats import qmc  # takes half a second to load: every command would wait

    block = 0
    while True:
        rng = int(generator(seed, f"{stream}/sobol", block).integers(2**31))
        yield from qmc.Sobol(d, scramble=True, rng=rng).random_base2(SOBOL_LOG2)
        block += 1


def spread(d: int, seed: int, stream: str) -> Iterator[Floats]:
    """Points (d,) without end, in turn of `sobol` and of another such sequence moved to edges.

    On an edge each coordinate is moved to its nearer end with probability `AT_END`. Failures that
    need three or four parameters near their ends together are far more frequent there than in the
    whole cube (docs/stress.md), and those that do not are found by the others.
    """
    edges = sobol(d, seed, f"{stream}/edges")
    for number, (inside, edge) in enumerate(zip(sobol(d, seed, stream), edges, strict=True)):
        yield inside
        moved = generator(seed, f"{stream}/edges", number).random(d) < AT_END
        yield np.where(moved, np.round(edge), edge)
