"""What an estimate asks of the world: the outcomes of draws, and how the draws are made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from sim.randomness import generator

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Outcomes of n draws.

    failed (n,); objective (n,): smaller is nearer to a failure, for adaptation alone; counted (n,):
    False where the draw is none, as a person could not perform it.
    """

    failed: Bools
    objective: Floats
    counted: Bools


class Play(Protocol):
    """Plays the draws of standard-normal latents (n, d), each with its own noise seed (n,)."""

    def __call__(self, latents: Floats, seeds: NDArray[np.int64]) -> Outcomes:
        """The outcome of each draw, in order."""
        ...


def normal_draws(seed: int, stage: str, n: int, d: int) -> Floats:
    """Standard-normal latents (n, d); row i depends on seed, stage and i alone."""
    rows = [generator(seed, f"stress/{stage}/latents", i).standard_normal(d) for i in range(n)]
    return np.array(rows, dtype=np.float64).reshape(n, d)


def noise_seeds(seed: int, stage: str, n: int) -> NDArray[np.int64]:
    """A noise seed (n,) for each draw of a stage; no two stages share their draws."""
    return np.array(
        [generator(seed, f"stress/{stage}/noise", i).integers(2**31) for i in range(n)],
        dtype=np.int64,
    )
