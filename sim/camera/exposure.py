"""The moments at which the scene is drawn to expose a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project
from sim.pose import Pose
from sim.script import Script

SUBFRAME_PX = 2.0  # largest motion from one sub-frame to the next
MOST_SUBFRAMES = 15  # odd; each costs as much as a picture
FINGERTIPS_M = 0.1  # ahead of the palm's centre
HEAD_M = 0.1  # from the head's centre to its face


def subframes(
    script: Script, cameras: Sequence[Camera], exposure_s: float, time_s: float
) -> tuple[float, ...]:
    """The moments [s] whose mean light is the picture exposed around time_s, in order.

    An odd number, evenly spaced over the exposure, with time_s in the middle: enough for heads,
    hands and objects to move SUBFRAME_PX at most from sub-frame to sub-frame, up to MOST_SUBFRAMES;
    a single one where nothing moves. No moment is before 0: there, the scene stands still.
    """
    if exposure_s == 0:
        return (time_s,)
    ends = [max(time_s + half * exposure_s, 0.0) for half in (-0.5, 0.0, 0.5)]
    marks = [marks_of(script.pose(t)) for t in ends]
    longest = 0.0
    for camera in cameras:
        at = np.array([project(camera, points) for points in marks])
        steps = np.linalg.norm(np.diff(at, axis=0), axis=-1).sum(axis=0)
        longest = max(longest, float(np.max(steps, where=np.isfinite(steps), initial=0.0)))
    half = min(math.ceil(longest / SUBFRAME_PX) // 2, MOST_SUBFRAMES // 2)
    count = 2 * half + 1
    return tuple(
        max(time_s + exposure_s * (k / count), 0.0) if k else time_s for k in range(-half, half + 1)
    )


def marks_of(pose: Pose) -> Floats:
    """The fastest points (n, 3) [m] of a pose: palms, finger tips, face, objects."""
    parts = [(pose.head, HEAD_M), *((hand, FINGERTIPS_M) for hand in pose.hands)]
    ahead = [part.position_m + reach * part.rotation[:, 0] for part, reach in parts]
    return np.array(
        [*(part.position_m for part, _ in parts), *ahead]
        + [pose.objects[name].position_m for name in sorted(pose.objects)]
    )
