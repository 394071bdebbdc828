"""Gestures of a hand that goes out of sight: hide behind an object, leave the view."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pjpdaf.errors import BenchError
from sim.contact.contact import Unposable
from sim.families.gestures.gesture import (
    DURATION,
    SPEED,
    Gesture,
    ObjectName,
    Quantity,
    Step,
    Word,
)
from sim.families.gestures.legs import Leg, lay
from sim.families.gestures.rehearsal import Rehearsal
from sim.families.leave_view import out_and_back
from sim.motion.planner import raised
from sim.person.kinematics import OUTWARD
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS

_EDGE_ON_RAD = math.pi / 2  # thumb up


def _hide(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hand comes down behind an object from above, edge-on to the cameras, and goes up again.

    It is on the line from a camera (both: from the middle between them) through the object's axis.
    """
    stage, name = rehearsal.stage, step.words["object"]
    spec, place = rehearsal.object_named(name)
    cameras = stereo_rig(stage.scene.rig).cameras
    centres = {view: camera.centre_w for view, camera in zip(CAMERAS, cameras, strict=True)}
    centres["both"] = 0.5 * (centres[CAMERAS[0]] + centres[CAMERAS[1]])
    camera = centres[step.words["view"]]
    away = place.position_m - camera
    away = np.array([away[0], away[1], 0.0]) / math.hypot(away[0], away[1])
    # Finger tips lead to the camera: the palm is half a hand behind the object's back.
    half = 0.5 * math.hypot(*spec.size_m[:2]) if spec.size_m[1] < 0.1 else 0.5 * spec.size_m[0]
    behind = half + step.number("gap") + 0.55 * stage.scene.anatomy.hand_length_m
    palm = place.position_m + behind * away
    palm[2] = stage.scene.room.table_height_m + step.number("height")
    inward = -OUTWARD[side] * math.atan2(-away[1], -away[0])
    hidden = raised(side, palm, inward, 0.0, _EDGE_ON_RAD, curl=step.number("curl"))
    hidden = replace(hidden, swivel_rad=step.number("elbow_out"))
    over = hidden.moved([-0.02, 0.0, step.number("lift")])
    hand = rehearsal.hands[side]
    lay(hand, [Leg((over,), bulge_m=(0.0, 0.0, 0.04)), Leg((hidden,))], step)
    hand.wait(step.number("hold"))
    lay(hand, [Leg((over,))], step.without_duration())


def _leave_view(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hand reaches sideways past the edge of one picture, then of both, and comes back."""
    try:
        cues, lean = out_and_back(rehearsal.stage_of(step), side, rehearsal.hands[side])
    except BenchError as fault:
        raise Unposable(f"{step.where}: {fault}") from None
    rehearsal.cues += cues
    rehearsal.leans.append(lean)


GESTURES = {
    "hide": Gesture(
        "comes down behind an object, out of sight, and goes up again",
        (
            ObjectName("object", "what it hides behind"),
            SPEED,
            DURATION,
            Quantity("hold", "s", 0.0, 600.0, "how long it stays there", 1.5),
            Word("view", (*CAMERAS, "both"), "of which camera; both: of their middle", "both"),
            Quantity("height", "m", 0.05, 0.5, "of the palm above the table", 0.08),
            Quantity("gap", "m", 0.005, 0.2, "finger tips from the object's back", 0.02),
            Quantity("lift", "m", 0.05, 0.4, "from which it comes down", 0.18),
            Quantity("curl", "1", 0.0, 0.9, "curl of the fingers", 0.3),
            Quantity("elbow_out", "rad", -0.5, 1.2, "elbow out beyond the person's habit", 0.1),
        ),
        _hide,
        leaves_view=True,
    ),
    "leave_view": Gesture(
        "reaches sideways out of one picture, then of both, and comes back",
        (
            Quantity("speed", "m/s", 0.1, 2.5, "peak speed", 0.6),
            Quantity("one_out", "s", 0.0, 60.0, "how long only one view has lost it", 0.6),
            Quantity("out", "s", 0.05, 60.0, "how long both have lost it", 0.7),
            Quantity("beyond", "px", 1, 60, "how far past the edge", 13),
            Quantity("start_x", "m", 0.26, 0.5, "where the way out begins: ahead", 0.32),
            Quantity("start_y", "m", 0.2, 0.4, "where it begins: outward", 0.29),
            Quantity("height", "m", 0.06, 0.4, "of the way out above the table", 0.28),
            Quantity("forward", "rad", -0.2, 0.6, "turned from sideways to forward", -0.06),
            Quantity("stretch", "1", 0.7, 0.97, "how straight the arm is", 0.945),
        ),
        _leave_view,
        leaves_view=True,
    ),
}
