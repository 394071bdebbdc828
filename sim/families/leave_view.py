"""A hand that leaves the picture of one camera, then of both."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, distort_points, project, to_camera
from pjpdaf.errors import BenchError
from sim.anatomy import Anatomy
from sim.contact.capsules import Capsules
from sim.families.touching import hand_bars
from sim.motion.bisection import bisect
from sim.motion.carriage import Carriage, Lean
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import HandPlanner, raised
from sim.motion.posture import posture
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD, shoulders
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS
from sim.vectors import norm

_MAX_LEAN_RAD = 0.5  # aside


def _outside_px(camera: Camera, bars: Capsules) -> float:
    """Distance of the bars from the picture's edge [px], negative while any of them is inside."""
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
    """The hand moved along a unit vector (3,) until it is px [px] outside: a state per view.

    In order of distance. Raises BenchError where a metre is not enough.
    """

    def outside(camera: Camera, along_m: float) -> bool:
        return _outside_px(camera, hand_bars(anatomy, side, state.moved(along_m * way))) >= px

    ends = []
    for camera in cameras:
        if not outside(camera, 1.0):
            raise BenchError(
                "leave_view: the picture is too wide for a hand to leave it: raise focal, or "
                "lower rig_distance"
            )
        ends.append(bisect(0.0, 1.0, 30, partial(outside, camera))[1])
    return [state.moved(along_m * way) for along_m in sorted(ends)]


def _lean_towards(stage: Stage, side: int, state: HandState) -> float:
    """The least lean aside [rad, to the left] with which the arm reaches `state` and is stretched
    no further than the parameter `stretch` allows."""
    anatomy, other = stage.scene.anatomy, stage.rest(1 - side)
    hands = (state, other) if side == 0 else (other, state)
    wrist = state.position_m - anatomy.wrist_to_palm_m * state.rotation[:, 0]
    reach = stage.number("stretch") * (anatomy.upper_arm_m + anatomy.forearm_m)

    def reaches(lean: float) -> bool:
        held = Carriage(sideways_rad=OUTWARD[side] * lean)
        torso, _ = posture(anatomy, hands, np.zeros(3), held)
        return norm(wrist - shoulders(anatomy, torso.position_m, torso.rotation)[side]) <= reach

    return OUTWARD[side] * bisect(0.0, _MAX_LEAN_RAD, 20, reaches)[1]


def _leave_view(stage: Stage) -> MotionPlan:
    """A hand reaches sideways past the edge of one picture, then of both, and comes back."""
    side = stage.side("hand")
    hands = stage.planners(stage.start_s)
    cues, carriage = out_and_back(stage, side, hands[side])
    hands[side].move(stage.rest(side), stage.number("speed"), [0.0, 0.0, 0.02])
    return stage.plan(hands, cues=cues, carriage=carriage)


def out_and_back(stage: Stage, side: int, hand: HandPlanner) -> tuple[tuple[Cue, ...], Lean]:
    """Add the moves of a hand out of both pictures and back; returns cues, and the torso's lean.

    Raises BenchError where a metre aside is not enough.
    """
    speed = stage.number("speed")
    outward, anatomy = OUTWARD[side], stage.scene.anatomy
    turn = stage.number("forward")
    way = np.array([math.sin(turn), outward * math.cos(turn), 0.0])
    z = stage.scene.room.table_height_m + stage.number("height")
    start = np.array([stage.number("start_x"), outward * stage.number("start_y"), z])
    # Fingers lead, palm down; near the body a wrist does not bend that far.
    ready = raised(side, start, -0.3 * (0.5 * math.pi - turn), 0.0, 0.2, curl=0.12)
    stretched = raised(side, start, turn - 0.5 * math.pi, 0.0, 0.2, curl=0.12)
    cameras = stereo_rig(stage.scene.rig).cameras
    first, both = _way_out(cameras, anatomy, side, stretched, way, stage.number("beyond"))
    hand.move(ready, speed, [0.0, 0.0, 0.02])
    leaning = hand.clock_s
    hand.move(first, speed)
    first_out = hand.clock_s
    hand.wait(stage.number("one_out"))
    hand.move(both, speed)
    both_out = hand.clock_s
    hand.wait(stage.number("out"))
    returning = hand.clock_s
    hand.move(ready, speed)
    lean = _lean_towards(stage, side, both)
    carriage = Lean(leaning, first_out, returning, hand.clock_s, sideways_rad=lean)
    # The camera on the far side of the robot sees less of this side.
    camera = CAMERAS[1 - side]
    cues = (
        Cue(f"out:{camera}_view", first_out, returning),
        Cue("out", both_out, returning),
    )
    return cues, carriage


FAMILIES: Mapping[str, Family] = {
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
        _leave_view,
    ),
}
