"""A post between a hand and one of the cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.errors import BenchError
from sim.contact.capsules import Capsules
from sim.families.touching import hand_bars
from sim.motion.motion import Cue, MotionPlan, object_at_rest
from sim.motion.planner import raised
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS
from sim.specs import ObjectSpec, RoomSpec

_EDGE_ON_RAD = math.pi / 2  # thumb up

_FOOT_M = 0.05  # no post's foot reaches further from its axis


def _post_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """A post that throws two shadows, one of each camera, on the depth at which the hand will stop.

    The outer shadow, of the camera on the hand's own side, is `aside` from the mid-plane there; the
    other lies further in by baseline x (hand - post) / (post - rig). A post that does not fit on
    the table stands on the floor before it.
    """
    outward = OUTWARD[side_of(values, "hand")]
    distance, ahead = number(values, "rig_distance"), number(values, "post_distance")
    camera_y = -outward * number(values, "baseline") / 2
    share = ahead / (distance - number(values, "centre_x"))
    x, y = distance - ahead, camera_y + (outward * number(values, "aside") - camera_y) * share
    # As high as the line from the cameras that passes `cover` over the palm.
    table, rig_z = number(values, "table_height"), number(values, "rig_height")
    covered = table + number(values, "height") + number(values, "cover")
    top = rig_z + (covered - rig_z) * share
    on_table = x + _FOOT_M <= number(values, "table_near") + float(
        values.get("table_depth", RoomSpec().table_depth_m)
    )
    width = number(values, "post_width")
    return (
        ObjectSpec(
            "post",
            "post",
            (width, width, top - table if on_table else top),
            (0.10, 0.11, 0.12),
            (x, y),
            base_m=None if on_table else 0.0,
        ),
    )


def _azimuths(bars: Capsules, centre_m: Floats) -> tuple[float, float]:
    """Least and greatest angle about the vertical at which a camera at centre_m (3,) sees bars."""
    points = np.concatenate([bars.starts_m, bars.ends_m]) - centre_m
    radii = np.concatenate([bars.radii_m, bars.radii_m])
    angle = np.arctan2(points[:, 1], -points[:, 0])
    half = np.arcsin(radii / np.hypot(points[:, 0], points[:, 1]))
    return float((angle - half).min()), float((angle + half).max())


def _behind(stage: Stage, side: int, camera: Camera, post: ObjectSpec) -> HandState:
    """The hand edge-on, fingers to the camera, in the middle of the post's shadow.

    Raises BenchError where hand and post are as far from the camera.
    """
    centre = camera.centre_w
    at = object_at_rest(stage.scene.room, post.name).position_m - centre
    bearing = math.atan2(at[1], -at[0])
    x = stage.number("centre_x")
    if x >= post.position_xy_m[0]:
        raise BenchError(
            f"one_view_occluder: the hand at centre_x {x:g} m is not behind the post at "
            f"{post.position_xy_m[0]:g} m: lower centre_x or post_distance"
        )
    z = stage.scene.room.table_height_m + stage.number("height")
    y = float(centre[1] + math.tan(bearing) * (centre[0] - x))
    for _ in range(3):  # the hand's middle is not its palm's centre
        away = centre - np.array([x, y, z])
        azimuth = math.atan2(away[1], away[0])
        dip = -math.atan2(away[2], math.hypot(away[0], away[1]))
        inward = -OUTWARD[side] * azimuth
        state = raised(side, [x, y, z], inward, dip, _EDGE_ON_RAD, curl=stage.number("curl"))
        low, high = _azimuths(hand_bars(stage.scene.anatomy, side, state), centre)
        y += (bearing - 0.5 * (low + high)) * float(centre[0] - x)
    return state


def _one_view_occluder(stage: Stage) -> MotionPlan:
    """A hand comes down behind the post from above, waits there, goes up again; `visits` times."""
    side, speed, view = stage.side("hand"), stage.number("speed"), str(stage.values["view"])
    post, _ = stage.object_named("post")
    camera = stereo_rig(stage.scene.rig).cameras[CAMERAS.index(view)]
    hidden = _behind(stage, side, camera, post)
    up = np.array([-0.02, 0.0, stage.number("lift")])
    over = hidden.moved(up)
    out = np.array([0.0, OUTWARD[side] * stage.number("away"), -0.4 * stage.number("lift")])
    apart = over.moved(out)
    hands = stage.planners(stage.start_s)
    hand = hands[side]
    hand.move(over, speed, [0.0, 0.0, 0.04])
    cues = []
    for visit in range(round(stage.number("visits"))):
        if visit:
            hand.move(apart, speed)
            hand.wait(stage.number("pause"))
            hand.move(over, speed)
        hand.wait(0.3)
        hand.move(hidden, speed)
        arrived = hand.clock_s
        hand.wait(stage.number("hidden"))
        cues.append(Cue(f"hidden:{view}_view", arrived, hand.clock_s))
        hand.move(over, speed)
        hand.wait(0.3)
    hand.move(stage.rest(side), speed, [0.0, 0.0, 0.04])
    return stage.plan(hands, cues=tuple(cues))


FAMILIES: Mapping[str, Family] = {
    "one_view_occluder": Family(
        (
            "hand",
            "view",
            "speed",
            "wait",
            "hidden",
            "visits",
            "pause",
            "post_width",
            "post_distance",
            "cover",
            "aside",
            "centre_x",
            "height",
            "curl",
            "lift",
            "away",
        ),
        _one_view_occluder,
        _post_objects,
    ),
}
