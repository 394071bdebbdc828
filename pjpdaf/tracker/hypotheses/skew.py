"""Skew: the second view is exposed earlier or later than the first, learnt from moving hands.

A hand that moves is seen at two places then, and its disparity says more of its speed than of its
depth: at 0.5 m/s and 50 ms, 1 m before cameras 9 cm apart, it is 0.3 m off. Across the epipolar
lines nothing but the skew can part the views. That part of a hand's displacement, for its speed
across the lines since the frame before, is regressed; the part along the lines follows.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.memory import kept_share
from pjpdaf.tracker.hypotheses.parameters import FRAME_S

NOISE_PX = 1.0  # of a place across the lines, at 640 columns
CERTAIN = 4.0  # log-odds of a skew against any of the other sign, at which it is taken to be one
LONGEST_S = 0.1  # which cameras that belong together differ by
USUAL_S = 0.05  # deviation of skews
STEPS = 40  # of the grid of skews, on either side of 0
FARTHEST = 3.0  # deviations; a sighting farther off says no more
LEAST_PXPS = 40.0  # a slower hand says nothing
NEAR_FAR = 0.7, 1.5  # of an expected depth: they span an epipolar line
MEMORY_S = 120.0
# Of a hand's speed of the moment, at FRAME_S after the frame before: the share of the mean speed
# since then, and the deviation from it across the lines; the share that goes with the part across
# them, and the deviation from all that along them (of natural motion, fitted) [1, px/s at 640].
MEAN_SHARE, ACROSS_PXPS = 0.8, 65.0
WITH_ACROSS, ALONG_PXPS = 0.25, 40.0
GRID_S = np.linspace(-LONGEST_S, LONGEST_S, 2 * STEPS + 1)


@dataclass(frozen=True, eq=False)
class Skew:
    """What is known of the skew: log-probability (g,) of each of GRID_S, up to a constant.

    noise_px: deviation of the displacement of a hand at rest across the lines.
    """

    noise_px: float
    log: Floats = field(default_factory=lambda: -0.5 * (GRID_S / USUAL_S) ** 2)

    @property
    def seconds(self) -> float:
        """Seconds [s] by which the second view is later; 0 while its sign is not certain."""
        best = int(self.log.argmax())
        other = self.log[: STEPS + 1] if best > STEPS else self.log[STEPS:]
        if best == STEPS or self.log[best] < other.max() + CERTAIN:
            return 0.0
        return float(GRID_S[best])

    @property
    def spread_s(self) -> float:
        """Deviation of the skew [s]."""
        weight = np.exp(self.log - self.log.max())
        mean = weight @ GRID_S / weight.sum()
        return float((weight @ (GRID_S - mean) ** 2 / weight.sum()) ** 0.5)

    def after(self, r_px: Floats, v_pxps: Floats, dt_s: float) -> Skew:
        """The knowledge after sightings (n,) of a frame dt_s later.

        r_px: displacements across the epipolar lines of the second view; v_pxps: mean speeds across
        them since the frame before.
        """
        kept = kept_share(dt_s, MEMORY_S)
        use = (np.abs(v_pxps) > LEAST_PXPS) | (np.abs(r_px) > FARTHEST * self.noise_px)
        use &= np.abs(r_px) < 4 * self.noise_px + 1.5 * LONGEST_S * np.abs(v_pxps)
        share, sd_pxps = speed_of_moment(dt_s, self.noise_px)
        variance = self.noise_px**2 + (GRID_S * sd_pxps) ** 2
        off = r_px[use][:, None] - GRID_S * share * v_pxps[use][:, None]
        log = -0.5 * np.minimum(off**2 / variance, FARTHEST**2) - 0.5 * np.log(variance)
        return Skew(self.noise_px, kept * self.log + log.sum(axis=0))


def speed_of_moment(dt_s: float, scale: float) -> tuple[float, float]:
    """Share of a mean speed in that of the moment dt_s later, and deviation [px/s] across lines."""
    part = min(dt_s / FRAME_S, 1.0)
    return 1.0 - (1.0 - MEAN_SHARE) * part, ACROSS_PXPS * part * scale


@dataclass(frozen=True, eq=False)
class Shifts:
    """Of n pairs of places in two views: displacement r_px (n,) across the epipolar lines of the
    second view; velocity (n, 2) [px/s] in that view, and the part of it across the lines (n,), in
    the directions normal (n, 2).
    """

    r_px: Floats
    velocity: Floats
    across: Floats
    normal: Floats


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
    return Shifts(r, velocity, (velocity * normal).sum(axis=1), normal)


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
        mean, noise = self.skew.seconds, self.skew.noise_px
        if mean == 0.0 or not of.any():
            return right_px, np.zeros(len(left_px))
        s = shifts(views, left_px, right_px, self.hands_m, self.dt_s)
        share, sd_pxps = speed_of_moment(self.dt_s, noise)
        expected = share * s.across
        trust = sd_pxps**2 / (sd_pxps**2 + (noise / mean) ** 2)
        across = expected + trust * (s.r_px / mean - expected)
        # Along the lines the speed is a share of the mean, the more the more it is so across them.
        changed = across * s.across / (s.across**2 + ACROSS_PXPS**2)
        along = s.velocity - s.across[:, None] * s.normal
        factor = share - WITH_ACROSS + WITH_ACROSS * np.clip(changed / share, -1.0, 2.5)
        now = across[:, None] * s.normal + factor[:, None] * along
        sd = np.hypot(
            mean * ALONG_PXPS * min(self.dt_s / FRAME_S, 1.0) * noise,
            self.skew.spread_s * np.linalg.norm(now, axis=1),
        )
        return np.where(of[:, None], right_px - mean * now, right_px), np.where(of, sd, 0.0)
