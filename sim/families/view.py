"""View and field of view: a hand that one or both cameras lose."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points, project, to_camera
from pjpdaf.errors import BenchError
from sim.anatomy import Anatomy
from sim.contact.contact import Capsules, hand_capsules
from sim.motion.motion import Carriage, Cue, MotionPlan, object_at_rest, posture
from sim.motion.planner import HandPlanner, raised
from sim.motion.stage import STILL_S, Family, Stage, Values, no_objects, number, side_of
from sim.motion.strokes import HandState, minimum_jerk
from sim.person.kinematics import OUTWARD, shoulders
from sim.scene.rig import stereo_rig
from sim.specs import ObjectSpec, RoomSpec
from sim.vectors import norm

VIEWS = ("left", "right")
_EDGE_ON_RAD = math.pi / 2  # thumb up
_MAX_LEAN_RAD = 0.5  # aside
_FOOT_M = 0.05  # no post's foot reaches further from its axis


def _outline(anatomy: Anatomy, side: int, state: HandState) -> Capsules:
    """The hand's bars in the world."""
    return hand_capsules(anatomy, side, state.curls).placed(state.position_m, state.rotation)


@dataclass(frozen=True)
class Lean:
    """The torso leans, stays so, and comes back.

    start_s, there_s, leave_s, back_s: when it begins, is there, begins to come back, is back. The
    angles are those of `sim.motion.motion.Carriage`.
    """

    start_s: float
    there_s: float
    leave_s: float
    back_s: float
    forward_rad: float = 0.0
    sideways_rad: float = 0.0

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        going = minimum_jerk((t_s - self.start_s) / (self.there_s - self.start_s))
        coming = minimum_jerk((t_s - self.leave_s) / (self.back_s - self.leave_s))
        share = going - coming
        return Carriage(
            forward_rad=share * self.forward_rad, sideways_rad=share * self.sideways_rad
        )


# A post between the hand and one camera.


def _post_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """A post that throws two shadows, one per camera, on the depth at which the hand will stop.

    The outer one, of the camera on the hand's own side, is `aside` from the mid-plane there; the
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
    on_table = x + _FOOT_M <= number(values, "table_near") + RoomSpec().table_depth_m
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
        low, high = _azimuths(_outline(stage.scene.anatomy, side, state), centre)
        y += (bearing - 0.5 * (low + high)) * float(centre[0] - x)
    return state


def _one_view_occluder(stage: Stage) -> MotionPlan:
    """A hand comes down behind the post from above, waits there, goes up again; `visits` times."""
    side, speed, view = stage.side("hand"), stage.number("speed"), str(stage.values["view"])
    post = stage.scene.room.objects[0]
    camera = stereo_rig(stage.scene.rig).cameras[VIEWS.index(view)]
    hidden = _behind(stage, side, camera, post)
    up = np.array([-0.02, 0.0, stage.number("lift")])
    over = replace(hidden, position_m=hidden.position_m + up)
    out = np.array([0.0, OUTWARD[side] * stage.number("away"), -0.4 * stage.number("lift")])
    apart = replace(over, position_m=over.position_m + out)
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand = hands[side]
    hand.until(STILL_S + stage.number("wait"))
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


# Under the table.


def _hand_under_table(stage: Stage) -> MotionPlan:
    """Back over the table's near edge beside the belly, down, forward over the thigh; and back."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, room = OUTWARD[side], stage.scene.room
    near, top = room.table_near_x_m, room.table_height_m
    beside = stage.number("beside")

    def at(x: float, y: float, z: float, down: float, inward: float) -> HandState:
        place = [near + x, outward * y, top + z]
        return raised(side, place, inward, down, 0.2, curl=0.3, swivel_rad=0.3)

    # The palm passes the edge this far before it, so that the fingers clear it.
    gap = -0.49 * stage.scene.anatomy.hand_length_m
    over = at(0.02, beside, 0.09, 0.1, 0.3)
    before = at(gap, beside, 0.06, 0.3, 0.3)
    below = at(gap, beside, -0.13, 0.2, 0.3)
    under = at(stage.number("under_x"), stage.number("under_y"), -stage.number("depth"), 0.05, 0.3)
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand = hands[side]
    hand.until(STILL_S + stage.number("wait"))
    begun = hand.clock_s
    hand.move(over, speed)
    hand.move(before, 0.8 * speed)
    hand.move(below, 0.8 * speed)
    hand.move(under, speed)
    arrived = hand.clock_s
    hand.wait(stage.number("under"))
    left = hand.clock_s
    hand.move(below, speed)
    hand.move(before, 0.8 * speed)
    hand.move(over, 0.8 * speed)
    back = stage.rest(side, stage.number("back_x"), stage.number("back_y"))
    hand.move(back, speed, [0.0, 0.0, 0.02])
    cues = (
        Cue("go_under", begun, arrived),
        Cue("under_table", arrived, left),
        Cue("come_back", left, hand.clock_s),
    )
    # Leaning back makes room between belly and table.
    carriage = Lean(begun, arrived, left, hand.clock_s, forward_rad=-stage.number("back"))
    return stage.plan(hands, cues=cues, carriage=carriage)


# Out of the picture.


def _outside_px(camera: Camera, bars: Capsules) -> float:
    """How far the nearest part of the bars is past the picture's edge [px]; < 0: some is inside."""
    points = np.concatenate([bars.starts_m, bars.ends_m])
    radii = np.concatenate([bars.radii_m, bars.radii_m])
    pixels = distort_points(camera, project(camera, points))
    pad = camera.K[0, 0] * radii / to_camera(camera, points)[:, 2]
    u, v = pixels[:, 0], pixels[:, 1]
    sides = [-0.5 - u, u - camera.width_px + 0.5, -0.5 - v, v - camera.height_px + 0.5]
    return float((np.max(sides, axis=0) - pad).min())


def _way_out(
    cameras: Sequence[Camera], anatomy: Anatomy, side: int, state: HandState, way: Floats, px: float
) -> list[HandState]:
    """The hand moved along way (3,), a unit vector, until it is px outside: one state per view.

    In order of distance. Raises BenchError where one metre is not enough.
    """

    def moved(along_m: float) -> HandState:
        return replace(state, position_m=state.position_m + along_m * way)

    ends = []
    for camera in cameras:
        low, high = 0.0, 1.0
        if _outside_px(camera, _outline(anatomy, side, moved(high))) < px:
            raise BenchError(
                "leave_view: the picture is too wide for a hand to leave it: raise focal, or "
                "lower rig_distance"
            )
        for _ in range(30):
            middle = 0.5 * (low + high)
            out = _outside_px(camera, _outline(anatomy, side, moved(middle))) >= px
            low, high = (low, middle) if out else (middle, high)
        ends.append(high)
    return [moved(along_m) for along_m in sorted(ends)]


def _lean_towards(stage: Stage, side: int, state: HandState) -> float:
    """The least lean aside [rad, to the left] at which the arm reaches `state` no straighter than
    the parameter `stretch` says."""
    anatomy, other = stage.scene.anatomy, stage.rest(1 - side)
    hands = (state, other) if side == 0 else (other, state)
    wrist = state.position_m - anatomy.wrist_to_palm_m * state.rotation[:, 0]
    reach = stage.number("stretch") * (anatomy.upper_arm_m + anatomy.forearm_m)

    def too_far(lean: float) -> bool:
        held = Carriage(sideways_rad=OUTWARD[side] * lean)
        torso, _ = posture(anatomy, hands, np.zeros(3), held)
        return norm(wrist - shoulders(anatomy, torso.position_m, torso.rotation)[side]) > reach

    low, high = 0.0, _MAX_LEAN_RAD
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if too_far(middle) else (low, middle)
    return OUTWARD[side] * high


def _leave_view(stage: Stage) -> MotionPlan:
    """A hand reaches sideways past the edge of one picture, then of both, and comes back."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, anatomy = OUTWARD[side], stage.scene.anatomy
    turn = stage.number("forward")
    way = np.array([math.sin(turn), outward * math.cos(turn), 0.0])
    z = stage.scene.room.table_height_m + stage.number("height")
    start = np.array([stage.number("start_x"), outward * stage.number("start_y"), z])
    # Fingers lead, palm down; near the body a wrist does not bend that far.
    ready = raised(side, start, -0.3 * (0.5 * math.pi - turn), 0.0, 0.2, curl=0.12)
    stretched = raised(side, start, turn - 0.5 * math.pi, 0.0, 0.2, curl=0.12)
    cameras = stereo_rig(stage.scene.rig).cameras
    one, both = _way_out(cameras, anatomy, side, stretched, way, stage.number("beyond"))
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand = hands[side]
    hand.until(STILL_S + stage.number("wait"))
    hand.move(ready, speed, [0.0, 0.0, 0.02])
    leaning = hand.clock_s
    hand.move(one, speed)
    first_out = hand.clock_s
    hand.wait(stage.number("one_out"))
    hand.move(both, speed)
    both_out = hand.clock_s
    hand.wait(stage.number("out"))
    returning = hand.clock_s
    hand.move(ready, speed)
    back = hand.clock_s
    hand.move(stage.rest(side), speed, [0.0, 0.0, 0.02])
    lean = _lean_towards(stage, side, both)
    carriage = Lean(leaning, first_out, returning, back, sideways_rad=lean)
    # The camera on the far side of the robot sees less of this side.
    first = VIEWS[1 - side]
    cues = (
        Cue(f"out:{first}_view", first_out, returning),
        Cue("out", both_out, returning),
    )
    return stage.plan(hands, cues=cues, carriage=carriage)


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
        _post_objects,
        _one_view_occluder,
    ),
    "hand_under_table": Family(
        (
            "hand",
            "speed",
            "wait",
            "under",
            "beside",
            "under_x",
            "under_y",
            "depth",
            "back",
            "back_x",
            "back_y",
        ),
        no_objects,
        _hand_under_table,
    ),
    "leave_view": Family(
        (
            "hand",
            "speed",
            "wait",
            "one_out",
            "out",
            "beyond",
            "start_x",
            "start_y",
            "height",
            "forward",
            "stretch",
        ),
        no_objects,
        _leave_view,
    ),
}
