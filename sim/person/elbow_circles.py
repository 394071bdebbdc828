"""Elbow circles of many arms at once: `within_reach` and `elbow_circle` of `sim.person.kinematics`.

To the bit as these: the same sums in the same order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.person.kinematics import OUTWARD, ElbowCircle, reach_limits
from sim.vectors import dots


def within_reach_over(
    shoulder_m: Floats, wrist_m: Floats, upper_m: float, forearm_m: float
) -> Floats:
    """Wrists (n, 3), moved along their line to the shoulder (n, 3) into reach where outside."""
    offset = wrist_m - shoulder_m
    distance = np.sqrt(dots(offset, offset))
    none = distance < 1e-9
    offset[none], distance[none] = (1.0, 0.0, 0.0), 1.0
    kept = np.clip(distance, *reach_limits(upper_m, forearm_m)) / distance
    return np.asarray(shoulder_m + offset * kept[:, None])


@dataclass(frozen=True, eq=False)
class ElbowCircles:
    """Where the elbows may be: centre_m (n, 3) + radius_m (n,) (cos swivel down (n, 3) + sin swivel
    outward (n, 3)).
    """

    centre_m: Floats
    radius_m: Floats
    down: Floats
    outward: Floats

    def elbows(self, cos: Floats, sin: Floats) -> Floats:
        """Elbows (n, 3) at swivels of these cosines and sines (n,)."""
        turned = cos[:, None] * self.down + sin[:, None] * self.outward
        return np.asarray(self.centre_m + self.radius_m[:, None] * turned)

    def least_swivels(self, heights_m: Floats) -> Floats:
        """The smallest swivels (n,) that keep the elbows at or above heights (n,)."""
        swivels = np.zeros(len(heights_m))
        low = self.radius_m * self.down[:, 2] < heights_m - self.centre_m[:, 2]
        # Few: one by one, as numpy's arc functions may differ from these in their last bit.
        for k in np.flatnonzero(low).tolist():
            circle = ElbowCircle(
                self.centre_m[k].tolist(),
                float(self.radius_m[k]),
                self.down[k].tolist(),
                self.outward[k].tolist(),
            )
            swivels[k] = circle.least_swivel(float(heights_m[k]))
        return swivels


def elbow_circles(
    side: int, shoulder_m: Floats, wrist_m: Floats, upper_m: float, forearm_m: float
) -> ElbowCircles:
    """The circles of arms from shoulders (n, 3) to wrists (n, 3), which must be within reach."""
    offset = wrist_m - shoulder_m
    d = np.sqrt(dots(offset, offset))
    axis = offset / d[:, None]
    along = (d * d + upper_m * upper_m - forearm_m * forearm_m) / (2.0 * d)
    radius = np.sqrt(np.maximum(upper_m * upper_m - along * along, 0.0))
    down = _hanging(side, axis)
    down = down - dots(down, axis)[:, None] * axis
    flat = np.sqrt(dots(down, down)) < 1e-3
    down[flat] = np.cross(axis[flat], [0.0, 1.0, 0.0])
    down /= np.sqrt(dots(down, down))[:, None]
    outward = OUTWARD[side] * _cross(axis, down)
    return ElbowCircles(shoulder_m + along[:, None] * axis, radius, down, outward)


def _hanging(side: int, axis: Floats) -> Floats:
    x, z = axis[:, 0], axis[:, 2]
    steep = np.maximum(0.0, np.abs(z) - 0.8) / 0.2
    behind = _smooth((0.25 - x) / 0.5) * _smooth(z / 0.6)
    still = 1.0 - behind
    return np.stack(
        [
            still * np.copysign(steep, z) + 0.8 * behind,
            0.6 * behind * OUTWARD[side],
            still * (-1.0 + 0.7 * steep) + 0.2 * behind,
        ],
        axis=1,
    )


def _smooth(share: Floats) -> Floats:
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))


def _cross(a: Floats, b: Floats) -> Floats:
    """a x b of (n, 3) arrays."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )
