"""The distribution that importance sampling draws from: nominal and adapted, mixed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.randomness import generator

NOMINAL_SHARE = 0.3


@dataclass(frozen=True, eq=False)
class Proposal:
    """A defensive mixture (Hesterberg 1995): `NOMINAL_SHARE` N(0, I), the rest adapted Gaussians.

    shares (K,) of the adapted part, means and sds (K, d). Every weight is at most
    1 / NOMINAL_SHARE, whatever the adaptation has missed.
    """

    shares: Floats
    means: Floats
    sds: Floats

    def sample(self, seed: int, stage: str, n: int) -> tuple[Floats, int]:
        """Latents (n, d), the first of them nominal, and the number of these.

        The component of a draw follows from its number, so that each has its exact share.
        """
        nominal = math.ceil(NOMINAL_SHARE * n)
        places = (np.arange(n - nominal) + 0.5) / max(n - nominal, 1)
        component = np.searchsorted(np.cumsum(self.shares)[:-1], places)
        d = self.means.shape[1]
        rows = np.array(
            [generator(seed, f"stress/{stage}/latents", i).standard_normal(d) for i in range(n)]
        ).reshape(n, d)
        rows[nominal:] = self.means[component] + self.sds[component] * rows[nominal:]
        return rows, nominal

    def log_ratio(self, latents: Floats) -> Floats:
        """Log of adapted density / nominal density, (n,), of latents (n, d)."""
        scaled = (latents[:, None] - self.means) / self.sds
        log_parts = 0.5 * (np.sum(latents**2, axis=1)[:, None] - np.sum(scaled**2, axis=2))
        log_parts += np.log(self.shares) - np.log(self.sds).sum(axis=1)
        return np.asarray(np.logaddexp.reduce(log_parts, axis=1))

    def weights(self, latents: Floats, nominal_share: float) -> Floats:
        """Density ratio (n,) nominal / mixture of latents (n, d) (balance heuristic)."""
        ratio = np.exp(np.minimum(self.log_ratio(latents), 700.0))
        return np.asarray(1.0 / (nominal_share + (1.0 - nominal_share) * ratio))
