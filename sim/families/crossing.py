"""Cross and bounce: one approach, two outcomes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera
from sim.contact.contact import Capsules, capsule_gap, hand_capsules
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import HandPlanner, raised
from sim.motion.stage import STILL_S, Family, Stage, no_objects
from sim.motion.strokes import (
    Glide,
    HandState,
    Stroke,
    between,
    minimum_jerk,
    minimum_jerk_rate,
    minimum_jerk_second,
)
from sim.person.kinematics import OUTWARD
from sim.scene.rig import stereo_rig
from sim.vectors import norm

# The nearer arm reaches in from outside, the farther one over it: so the forearms pass each other.
_RISE_M = 0.045  # of the farther hand over the nearer one
_TILT_RAD = 0.6  # between the hands, so that their fingers meet all the same
_SWIVEL_RAD = 0.8  # between the elbows, outward that of the nearer one
_SHARES = 101  # of a stroke at which its pictures are looked at
_SURELY_PX = 4.0  # outlines that overlap by this much are one blob in any picture


Pair = tuple[HandState, HandState]


@dataclass(frozen=True, eq=False)
class Approach:
    """Both hands up, apart, one nearer to the cameras, about to stroke through the middle."""

    hands: tuple[HandPlanner, HandPlanner]
    apart: Pair
    crossed: Pair
    bows_m: tuple[Floats, Floats]


def approach(stage: Stage, bow_m: float = 0.0) -> Approach:
    """Raise both hands, as the parameters `APPROACH` say, ready to stroke across the middle.

    bow_m: of the strokes to come, along the depth, away from each other.
    """
    front = stage.side("front")
    gap, height, x = stage.number("depth_gap"), stage.number("height"), stage.number("centre_x")
    spread, past = stage.number("spread"), stage.number("past")
    apart, crossed, bows = [], [], []
    for side in (0, 1):
        ahead = 0.5 if side == front else -0.5
        away = np.array([ahead * gap, 0.0, -ahead * _RISE_M])
        centre = np.array([x, 0.0, stage.scene.room.table_height_m + height]) + away
        lateral = np.array([0.0, OUTWARD[side], 0.0])
        held = raised(
            side,
            centre,
            1.0,
            -0.35 - ahead * _TILT_RAD,
            1.2,
            curl=0.16,
            swivel_rad=ahead * _SWIVEL_RAD,
        )
        apart.append(replace(held, position_m=centre + spread * lateral))
        crossed.append(replace(held, position_m=centre - past * lateral))
        bows.append(np.array([2.0 * ahead * bow_m, 0.0, 0.0]))
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    start = STILL_S + stage.number("wait")
    for side in (0, 1):
        hands[side].until(start)
        hands[side].move(apart[side], stage.number("raise_speed"), [0.0, 0.0, 0.02])
    ready = max(hand.clock_s for hand in hands) + 0.4
    for hand in hands:
        hand.until(ready)
    return Approach(hands, (apart[0], apart[1]), (crossed[0], crossed[1]), (bows[0], bows[1]))


def merged_shares(stage: Stage, a: Approach, here: Pair, there: Pair) -> tuple[float, float]:
    """Shares of the way from here to there between which the hands are one blob, as cameras see.

    From the first on both views show one blob, until the last at least one does. Hands that never
    meet in the pictures have both where they come nearest.
    """
    shares = np.linspace(0.0, 1.0, _SHARES)
    cameras = stereo_rig(stage.scene.rig)
    gaps = np.empty((_SHARES, 2))
    shapes = [hand_capsules(stage.scene.anatomy, s, here[s].curls) for s in (0, 1)]
    for row, u in enumerate(shares.tolist()):
        bars = [
            shapes[s].placed(
                between(here[s], there[s], u, a.bows_m[s]).position_m, here[s].rotation
            )
            for s in (0, 1)
        ]
        for view, camera in enumerate((cameras.left, cameras.right)):
            gaps[row, view] = _blob_gap(camera, bars[0], bars[1])
    both, one = gaps.max(axis=1) < -_SURELY_PX, gaps.min(axis=1) < 0.0
    if not both.any():
        nearest = float(shares[gaps.max(axis=1).argmin()])
        return nearest, nearest
    return float(shares[both.argmax()]), float(shares[np.flatnonzero(one)[-1]])


def _blob_gap(camera: Camera, right: Capsules, left: Capsules) -> float:
    """Distance [px] of two hands' outlines in a view, negative where they overlap."""
    places, radii = [], []
    for bars in (right, left):
        points = np.concatenate([bars.starts_m, 0.5 * (bars.starts_m + bars.ends_m), bars.ends_m])
        places.append(project(camera, points))
        radii.append(np.tile(bars.radii_m, 3) * camera.K[0, 0] / to_camera(camera, points)[:, 2])
    offsets = places[0][:, None] - places[1][None]
    distances = np.sqrt((offsets * offsets).sum(axis=-1))
    return float((distances - radii[0][:, None] - radii[1][None]).min())


def _merging(stage: Stage, a: Approach) -> tuple[float, float]:
    """Shares of the crossing's way at which the hands merge, and part.

    They merge where they do in both pictures, and not before their palms are merge_gap apart.
    """
    spread, past = stage.number("spread"), stage.number("past")
    first, last = merged_shares(stage, a, a.apart, a.crossed)
    first = max(first, (spread - 0.5 * stage.number("merge_gap")) / (spread + past))
    return first, max(first, last)


def share_time(u: float) -> float:
    """The share s of the time with minimum_jerk(s) = u, by bisection to 1e-15."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if minimum_jerk(middle) < u else (low, middle)
    return 0.5 * (low + high)


def during(name: str, stroke: Stroke, shares: tuple[float, float]) -> Cue:
    """The time in which a stroke goes from one share of its way to another."""
    first, last = (stroke.start_s + stroke.duration_s * share_time(u) for u in shares)
    return Cue(name, first, last)


def lower(stage: Stage, hands: tuple[HandPlanner, HandPlanner]) -> None:
    """Both hands back to their places on the table."""
    for side in (0, 1):
        hands[side].move(stage.rest(side), stage.number("raise_speed"), [0.0, 0.0, 0.02])


def _cross(stage: Stage) -> MotionPlan:
    """The hands pass each other, stay crossed, and go back if the parameter `back` says so."""
    a = approach(stage, stage.number("bow"))
    speed = stage.number("speed")
    strokes = [a.hands[s].move(a.crossed[s], speed, a.bows_m[s]) for s in (0, 1)]
    cues = [during("cross", strokes[0], _merging(stage, a))]
    crossed_s = strokes[0].end_s
    for hand in a.hands:
        hand.wait(stage.number("hold"))
    held_s = a.hands[0].clock_s
    cues.append(Cue("crossed", crossed_s, held_s))
    if stage.values["back"] == "yes":
        strokes = [a.hands[s].move(a.apart[s], speed, a.bows_m[s]) for s in (0, 1)]
        cues.append(Cue("cross_back", strokes[0].start_s, strokes[0].end_s))
        for hand in a.hands:
            hand.wait(0.4)
        lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def _touching(stage: Stage, a: Approach) -> tuple[Floats, Floats]:
    """Palms (right, left), each (3,) [m], where the hands just touch: laid over each other.

    They are touch_gap apart across; along the depth, as little as leaves them out of each other.
    """
    centre = 0.5 * (a.crossed[0].position_m + a.crossed[1].position_m)
    across = 0.5 * stage.number("touch_gap")
    depth = a.apart[0].position_m - a.apart[1].position_m
    depth = np.array([depth[0], 0.0, depth[2]]) / math.hypot(depth[0], depth[2])

    def places(gap_m: float) -> tuple[Floats, Floats]:
        right = centre + 0.5 * gap_m * depth + np.array([0.0, OUTWARD[0] * across, 0.0])
        left = centre - 0.5 * gap_m * depth + np.array([0.0, OUTWARD[1] * across, 0.0])
        return right, left

    shapes = [hand_capsules(stage.scene.anatomy, s, a.apart[s].curls) for s in (0, 1)]
    low, high = 0.0, 0.25
    for _ in range(20):
        middle = 0.5 * (low + high)
        bars = [shapes[s].placed(places(middle)[s], a.apart[s].rotation) for s in (0, 1)]
        low, high = (low, middle) if capsule_gap(bars[0], bars[1])[0] <= 0.0 else (middle, high)
    return places(high)


def brake(
    hand: HandPlanner, stroke: Stroke, begun: HandState, share: float, stop_m: Floats
) -> Glide:
    """Break off the hand's last stroke, which began in `begun`, after this share of its way.

    The hand goes on without a jump, comes to rest at stop_m (3,) and turns back to `begun`.
    """
    s, T = share_time(share), stroke.duration_s
    rate, second = minimum_jerk_rate(s) / T, minimum_jerk_second(s) / (T * T)
    way_m = stroke.to.position_m - begun.position_m
    along = way_m + 4.0 * (1.0 - 2.0 * share) * stroke.bulge_m
    velocity = rate * along
    acceleration = second * along - 8.0 * rate * rate * stroke.bulge_m
    broken_s = stroke.start_s + s * T
    # Twice the way over the speed: a brake that neither overshoots nor creeps.
    way = norm(stop_m - stroke.at(broken_s, begun).position_m)
    glide = Glide(
        start_s=broken_s,
        duration_s=max(2.0 * way / norm(velocity), 0.15),
        to=replace(begun, position_m=stop_m),
        velocity_mps=velocity,
        acceleration_mps2=acceleration,
        begun=begun,
        begun_share=share,
        begun_rate=rate,
    )
    hand.moves.append(glide)
    hand.clock_s = glide.end_s
    return glide


def _bounce(stage: Stage) -> MotionPlan:
    """The same approach, but where the hands would merge they brake, touch and return."""
    a = approach(stage, stage.number("bow"))
    speed = stage.number("speed")
    meeting = _merging(stage, a)[0]
    touching = _touching(stage, a)
    for side in (0, 1):
        stroke = a.hands[side].move(a.crossed[side], speed, a.bows_m[side])
        brake(a.hands[side], stroke, a.apart[side], meeting, touching[side])
    ended = max(hand.clock_s for hand in a.hands)
    cues = [Cue("bounce", a.hands[0].moves[-1].start_s, ended)]
    for side in (0, 1):
        hand = a.hands[side]
        hand.until(ended + stage.number("touch"))
        hand.move(a.apart[side], speed)
    touched = a.hands[0].moves[-1].start_s
    cues.append(Cue("touch", ended, touched))
    cues.append(Cue("return", touched, a.hands[0].clock_s))
    for hand in a.hands:
        hand.wait(stage.number("hold"))
    lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


APPROACH = (
    "speed",
    "raise_speed",
    "depth_gap",
    "front",
    "height",
    "centre_x",
    "spread",
    "past",
    "bow",
    "merge_gap",
    "wait",
    "hold",
)

FAMILIES: Mapping[str, Family] = {
    "cross": Family((*APPROACH, "back"), no_objects, _cross),
    "bounce": Family((*APPROACH, "touch_gap", "touch"), no_objects, _bounce),
}
