"""A clip's size and place on another body: the scale of its arms, its height over the table."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pjpdaf.arrays import Floats
from sim.clips.clips import Clip
from sim.pose import SIDES
from sim.specs import SceneSpec

# Seated shoulder width, acromion to acromion, over arm length: for clips without shoulders.
_HALF_BREADTH = 0.108 / (0.162 + 0.1545 + 0.045)

_AVERAGE_ARM_M = (0.162 + 0.1545 + 0.045) * 1.71

# A palm is never planned lower than this above the table; contact projection does the rest.
FLOOR_M = 0.040

_MAX_LIFT_M = 0.22

_LOW_SHARE = 0.15  # of the way the hands travel: may be pressed onto the table

_HIGH_SHARE = 0.05  # likewise: may be lifted higher than this above the shoulders

_HEADROOM_M = 0.30


@dataclass(frozen=True, eq=False)
class Fit:
    """The fit of a clip to a body: palm [m] = scale * clip + offset_m (3,), before limits; and a
    description of it for people."""

    scale: float
    offset_m: Floats
    description: str

    def placed(self, xyz: Floats) -> Floats:
        """Places (..., 3) of the clip in the world, before limits."""
        placed: Floats = self.scale * xyz + self.offset_m
        return placed


def fit_of(clip: Clip, scene: SceneSpec, scale: float, lift_m: float) -> Fit:
    """The fit of a clip to the person and the table of a scene; scale and lift_m add to it."""
    anatomy = scene.anatomy
    mine = anatomy.upper_arm_m + anatomy.forearm_m + anatomy.wrist_to_palm_m
    theirs, basis = _arm_length(clip)
    size = scale * mine / theirs
    origin = np.array([0.0, 0.0, anatomy.mid_shoulder_height_m - anatomy.shoulder_drop_m])
    low, high = _heights(clip)
    rise = scene.room.table_height_m + FLOOR_M - float(origin[2]) - size * low
    most = max(min(_MAX_LIFT_M, _HEADROOM_M - size * high), 0.0)
    lift = min(max(rise, 0.0), most) + lift_m
    description = f"{basis}; scaled by {size:.3f}, lifted by {lift:.3f} m"
    return Fit(size, origin + np.array([0.0, 0.0, lift]), description)


def _heights(clip: Clip) -> tuple[float, float]:
    """The heights [m] between which the hands do most of their way: idle hands do not count."""
    middles, ways = [], []
    for side in SIDES:
        path = clip.path(f"{side}_hand")
        ways.append(np.linalg.norm(np.diff(path, axis=0), axis=1))
        middles.append(0.5 * (path[1:, 2] + path[:-1, 2]))
    z, way = np.concatenate(middles), np.concatenate(ways)
    order = z.argsort()
    spent = np.cumsum(way[order])
    low, high = (
        float(z[order][min(np.searchsorted(spent, share * spent[-1]), len(z) - 1)])
        for share in (_LOW_SHARE, 1.0 - _HIGH_SHARE)
    )
    return low, high


def _arm_length(clip: Clip) -> tuple[float, str]:
    """Length from shoulder to palm along the recorded arm [m], and the basis of that figure."""
    lengths = []
    for side in SIDES:
        if clip.has(f"{side}_shoulder", f"{side}_elbow"):
            chain = [clip.path(f"{side}_{part}") for part in ("shoulder", "elbow", "hand")]
            if clip.has(f"{side}_wrist"):
                chain.insert(2, clip.path(f"{side}_wrist"))
            bones = [np.linalg.norm(b - a, axis=1) for a, b in pairwise(chain)]
            lengths.append(float(np.median(np.sum(bones, axis=0))))
    if lengths:
        return float(np.mean(lengths)), f"arm of {1000 * np.mean(lengths):.0f} mm as recorded"
    # Nobody reaches further than the arm is long.
    reach = []
    for side, outward in zip(SIDES, (-1.0, 1.0), strict=True):
        shoulder = np.array([0.0, outward * _HALF_BREADTH * _AVERAGE_ARM_M, 0.0])
        if clip.has(f"{side}_shoulder"):
            shoulder = clip.path(f"{side}_shoulder")
        offset = clip.path(f"{side}_hand") - shoulder
        reach.append(float(np.quantile(np.linalg.norm(offset, axis=1), 0.99)))
    arm = max(_AVERAGE_ARM_M, max(reach))
    if arm > _AVERAGE_ARM_M:
        return arm, f"no elbows: arm taken to be {1000 * arm:.0f} mm, the furthest reach"
    return arm, f"no elbows: arm taken to be the average, {1000 * arm:.0f} mm"
