"""Skew: the second view is exposed earlier or later than the first, learnt from moving hands.

A hand that moves is seen at two places then, and its disparity says more of its speed than of its
depth: at 0.5 m/s and 50 ms, 1 m before cameras 9 cm apart, it is 0.3 m off. Across the epipolar
lines nothing but the skew can part the views. That part of a hand's displacement, for its speed
across the lines since the frame before, is regressed; the part along the lines follows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.memory import kept_share

NOISE_PX = 1.0  # of a place across the lines, at 640 columns
CERTAIN = 4.0  # deviations from 0 at which a skew is taken to be one
LONGEST_S = 0.1  # which cameras that belong together differ by
LEAST_PXPS = 40.0  # a slower hand says nothing
NEAR_FAR = 0.7, 1.5  # of an expected depth: they span an epipolar line
MEMORY_S = 120.0
LEAST_SPREAD_S = 1e-4


@dataclass(frozen=True)
class Skew:
    """Sums over sightings of moving hands: speed v [px/s] and displacement r [px], both across the
    epipolar lines of the second view. The later the second view, the larger their ratio.

    noise_px: deviation of r of a hand at rest.
    """

    noise_px: float
    count: float = 0.0
    vv: float = 0.0
    rv: float = 0.0
    rr: float = 0.0

    @property
    def seconds(self) -> float:
        """Seconds [s] by which the second view is later, as far as a mean speed tells; 0 while
        that is not certain.
        """
        if abs(self.rv) < CERTAIN * self.noise_px * self.vv**0.5 or self.vv == 0:
            return 0.0
        return float(np.clip(self.rv / self.vv, -LONGEST_S, LONGEST_S))

    @property
    def spread_s(self) -> float:
        """How much single sightings deviate from it [s]: a speed changes between frames."""
        if self.vv == 0:
            return 0.0
        left = self.rr - self.rv**2 / self.vv - self.count * self.noise_px**2
        return float(max(left / self.vv, 0.0) ** 0.5)

    def after(self, r_px: Floats, v_pxps: Floats, dt_s: float) -> Skew:
        """The sums with sightings (n,) of a frame dt_s later."""
        kept = kept_share(dt_s, MEMORY_S)
        use = np.abs(v_pxps) > LEAST_PXPS
        use &= np.abs(r_px) < 4 * self.noise_px + 1.5 * LONGEST_S * np.abs(v_pxps)
        r, v = r_px[use], v_pxps[use]
        return Skew(
            self.noise_px,
            kept * self.count + len(r),
            kept * self.vv + float(v @ v),
            kept * self.rv + float(r @ v),
            kept * self.rr + float(r @ r),
        )


@dataclass(frozen=True, eq=False)
class Shifts:
    """Of n pairs of places in two views: displacement r_px (n,) across the epipolar lines of the
    second view; velocity (n, 2) [px/s] in that view, and the part of it across the lines (n,).
    """

    r_px: Floats
    velocity: Floats
    across: Floats


def shifts(views: Views, left_px: Floats, right_px: Floats, hands_m: Floats, dt_s: float) -> Shifts:
    """Shifts of pairs (n, 2), (n, 2) [px] since the nearest of the hands (h, 3) [m], dt_s ago."""
    pixels, depth = views.project(hands_m)
    away = np.linalg.norm(left_px[:, None] - pixels[0][None], axis=2)
    nearest = away.argmin(axis=1)
    rays = views.rays(0, left_px) * depth[0][nearest][:, None]
    at, _ = views.project(views.centres_m[0] + rays)
    ends, _ = views.project(views.centres_m[0] + np.array(NEAR_FAR)[:, None, None] * rays)
    line = ends[1, 1] - ends[1, 0]
    normal = np.stack([-line[:, 1], line[:, 0]], axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    velocity = (at[1] - pixels[1][nearest]) / dt_s
    r = ((right_px - at[1]) * normal).sum(axis=1)
    return Shifts(r, velocity, (velocity * normal).sum(axis=1))


@dataclass(frozen=True, eq=False)
class Skewed:
    """What takes the skew out of a frame: the skew, hands (h, 3) [m] of the frame before, dt_s."""

    skew: Skew
    hands_m: Floats
    dt_s: float

    def undone(
        self, views: Views, left_px: Floats, right_px: Floats, of: NDArray[np.bool_]
    ) -> tuple[Floats, Floats]:
        """Places (n, 2) [px] in the second view at the first one's moment, and how uncertain (n,)
        [px] the skew leaves them; those outside `of` (n,) stay.

        The speed of this moment differs from the mean since the frame before; a pair's own
        displacement across the lines tells by how much.
        """
        mean, spread = self.skew.seconds, max(self.skew.spread_s, LEAST_SPREAD_S)
        if mean == 0.0 or not of.any():
            return right_px, np.zeros(len(left_px))
        s = shifts(views, left_px, right_px, self.hands_m, self.dt_s)
        noise = self.skew.noise_px**2
        information = 1.0 / spread**2 + s.across**2 / noise
        seconds = (mean / spread**2 + s.r_px * s.across / noise) / information
        seconds = np.clip(seconds, mean - 2 * spread, mean + 2 * spread)
        moved = right_px - seconds[:, None] * s.velocity
        uncertain = np.linalg.norm(s.velocity, axis=1) / np.sqrt(information)
        return np.where(of[:, None], moved, right_px), np.where(of, uncertain, 0.0)
