"""What a real camera does to a rendered picture: noise."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sim.randomness import generator
from sim.specs import SensorSpec

RANKS = 2**16


def expose(
    picture: NDArray[np.uint8], spec: SensorSpec, seed: int, stream: str, frame: int
) -> NDArray[np.uint8]:
    """A picture (h, w, 3) uint8 with Gaussian noise of `noise_sd` grey levels on every channel.

    The noise is addressed by (seed, stream, frame): it does not depend on any other picture.
    Raises ValueError for a negative noise_sd.
    """
    if spec.noise_sd < 0:
        raise ValueError(f"noise_sd must not be negative, got {spec.noise_sd}")
    if spec.noise_sd == 0:
        return picture.copy()
    rng = generator(seed, f"noise/{stream}", frame)
    ranks = rng.integers(0, RANKS, size=picture.shape, dtype=np.uint16)
    # The picture is whole numbers, so rounding the sum is rounding the noise: a table will do.
    noise = np.take(rounded_gaussian(spec.noise_sd), ranks)
    noise += picture
    np.clip(noise, 0, 255, out=noise)
    return noise.astype(np.uint8)


@lru_cache(maxsize=8)
def rounded_gaussian(sd: float) -> NDArray[np.int16]:
    """Quantiles (RANKS,) of a Gaussian, rounded to whole grey levels; out to 4.3 sd."""
    quantiles = ndtri((np.arange(RANKS) + 0.5) / RANKS)
    return np.asarray(np.rint(sd * quantiles), dtype=np.int16)
