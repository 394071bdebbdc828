"""Whether a rig sees the person's head and hands: what a draw of a varied rig must keep."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import StereoRig, project
from scenarios.spec import person_and_room
from scenarios.spec.cameras import rig_of
from sim.motion.motion import Performer
from sim.motion.stage import Values, number
from sim.scene.rig import stereo_rig

# Over the table, where hands rest and work: ahead of the shoulders, to either side, above the top.
_AHEAD_M, _ASIDE_M, _ABOVE_M = (0.24, 0.50), 0.38, (0.03, 0.30)
_CROWN_M = 0.12  # of the head above its centre, and of the chin below it
_BORDER_PX = 6.0


def sees_workspace(values: Values) -> bool:
    """Whether the whole head and the space of the hands over the table are in both pictures."""
    anatomy, table = person_and_room.anatomy_of(values), number(values, "table_height")
    head = anatomy.mid_shoulder_height_m + anatomy.neck_to_head_centre_m
    points = [[0.02, 0.0, head + end] for end in (-_CROWN_M, _CROWN_M)]
    points += [[x, y, table + z] for x in _AHEAD_M for y in (-_ASIDE_M, _ASIDE_M) for z in _ABOVE_M]
    return not bool(_outside(stereo_rig(rig_of(values)), np.array(points), _BORDER_PX).any())


def out_of_view(performer: Performer, times_s: list[float]) -> str | None:
    """The fault that a palm's centre is not in both pictures at one of these times, or None.

    Not judged: a motion that leaves the view on purpose, by its cues.
    """
    plan = performer.plan
    if any(cue.name.startswith("out") for cue in plan.cues):
        return None
    rig = stereo_rig(performer.scene.rig)
    for side, name in enumerate(("right", "left")):
        palms = np.array([plan.hands[side].at(t_s).position_m for t_s in times_s])
        outside = _outside(rig, palms, 0.0)
        if outside.any():
            moment = times_s[int(np.argmax(outside))]
            return f"at {moment:.2f} s the {name} palm leaves the pictures: use another seed or rig"
    return None


def _outside(rig: StereoRig, points_w: Floats, border_px: float) -> np.ndarray:
    """Whether each point (n, 3) is out of, or at the border of, any picture."""
    outside = np.zeros(len(points_w), dtype=bool)
    for camera in rig.cameras:
        u, v = project(camera, points_w).T
        inside = (u >= border_px) & (u <= camera.width_px - 1 - border_px)
        inside &= (v >= border_px) & (v <= camera.height_px - 1 - border_px)
        outside |= ~inside
    return outside
