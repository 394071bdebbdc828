"""Cross and bounce: one approach, two outcomes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact import capsule_gap, hand_capsules
from sim.kinematics import OUTWARD, norm
from sim.motion import Cue, Plan
from sim.planner import HandPlanner, raised
from sim.stage import STILL_S, Gesture, Stage, no_objects
from sim.strokes import (
    Glide,
    HandState,
    Stroke,
    minimum_jerk,
    minimum_jerk_rate,
    minimum_jerk_second,
)

_RISE_M = 0.01  # of the farther hand over the nearer one: keeps it out of the other's forearm


@dataclass(frozen=True, eq=False)
class _Approach:
    """Both hands up, apart, one nearer to the cameras, about to stroke through the middle."""

    hands: tuple[HandPlanner, HandPlanner]
    apart: tuple[HandState, HandState]
    crossed: tuple[HandState, HandState]
    bows_m: tuple[Floats, Floats]


def _approach(stage: Stage) -> _Approach:
    front = stage.side("front")
    gap, height, x = stage.number("depth_gap"), stage.number("height"), stage.number("centre_x")
    spread, past, bow = stage.number("spread"), stage.number("past"), stage.number("bow")
    apart, crossed, bows = [], [], []
    for side in (0, 1):
        ahead = 0.5 if side == front else -0.5
        # The farther hand passes higher: below it, the nearer arm comes in from its elbow.
        away = np.array([ahead * gap, 0.0, -ahead * _RISE_M])
        centre = np.array([x, 0.0, stage.scene.room.table_height_m + height]) + away
        lateral = np.array([0.0, OUTWARD[side], 0.0])
        held = raised(side, centre, 1.0, -0.35, 1.2, curl=0.16)
        apart.append(replace(held, position_m=centre + spread * lateral))
        crossed.append(replace(held, position_m=centre - past * lateral))
        bows.append(np.array([2.0 * ahead * bow, 0.0, 0.0]))
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    start = STILL_S + stage.number("wait")
    for side in (0, 1):
        hands[side].until(start)
        hands[side].move(apart[side], stage.number("raise_speed"), [0.0, 0.0, 0.02])
    ready = max(hand.clock_s for hand in hands) + 0.4
    for hand in hands:
        hand.until(ready)
    return _Approach(hands, (apart[0], apart[1]), (crossed[0], crossed[1]), (bows[0], bows[1]))


def _meeting_share(stage: Stage) -> float:
    """Share u of the crossing stroke's way after which the palms are merge_gap apart across."""
    spread, past = stage.number("spread"), stage.number("past")
    return (spread - 0.5 * stage.number("merge_gap")) / (spread + past)


def _share_time(u: float) -> float:
    """The share s of the time with minimum_jerk(s) = u, by bisection to 1e-15."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if minimum_jerk(middle) < u else (low, middle)
    return 0.5 * (low + high)


def _lower(stage: Stage, hands: tuple[HandPlanner, HandPlanner]) -> None:
    """Both hands back to their places on the table."""
    for side in (0, 1):
        hands[side].move(stage.rest(side), stage.number("raise_speed"), [0.0, 0.0, 0.02])


def _cross(stage: Stage) -> Plan:
    """The hands pass each other, stay crossed, and go back if the parameter `back` says so."""
    a = _approach(stage)
    speed = stage.number("speed")
    strokes = [a.hands[s].move(a.crossed[s], speed, a.bows_m[s]) for s in (0, 1)]
    cues = [_merge_cue(stage, strokes[0], "cross")]
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
        _lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def _merge_cue(stage: Stage, stroke: Stroke, name: str) -> Cue:
    """The time of the stroke in which the palms are less than merge_gap apart across."""
    spread, past = stage.number("spread"), stage.number("past")
    entry = _meeting_share(stage)
    leave = min((spread + 0.5 * stage.number("merge_gap")) / (spread + past), 1.0)
    first, last = (stroke.start_s + stroke.duration_s * _share_time(u) for u in (entry, leave))
    return Cue(name, first, last)


def _touching(stage: Stage, a: _Approach) -> tuple[Floats, Floats]:
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


def _bounce(stage: Stage) -> Plan:
    """The same approach, but where the hands would merge they brake, touch and return."""
    a = _approach(stage)
    speed = stage.number("speed")
    meeting = _meeting_share(stage)
    s = _share_time(meeting)
    touching = _touching(stage, a)
    for side in (0, 1):
        hand = a.hands[side]
        start, goal, bow = a.apart[side].position_m, a.crossed[side].position_m, a.bows_m[side]
        stroke = hand.move(a.crossed[side], speed, bow)
        T, u = stroke.duration_s, meeting
        rate, second = minimum_jerk_rate(s) / T, minimum_jerk_second(s) / (T * T)
        along = goal - start + 4.0 * (1.0 - 2.0 * u) * bow
        velocity = rate * along
        acceleration = second * along - 8.0 * rate * rate * bow
        broken_s = stroke.start_s + s * T
        touch_m = touching[side]
        touch = replace(a.apart[side], position_m=touch_m)
        # Twice the way over the speed: a brake that neither overshoots nor creeps.
        way = norm(touch_m - stroke.at(broken_s, a.apart[side]).position_m)
        brake = Glide(
            start_s=broken_s,
            duration_s=max(2.0 * way / norm(velocity), 0.15),
            to=touch,
            velocity_mps=velocity,
            acceleration_mps2=acceleration,
            begun=a.apart[side],
            begun_share=u,
            begun_rate=rate,
        )
        hand.moves.append(brake)
        hand.clock_s = brake.end_s
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
    _lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


_APPROACH = (
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

FAMILIES: Mapping[str, Gesture] = {
    "cross": Gesture((*_APPROACH, "back"), no_objects, _cross),
    "bounce": Gesture((*_APPROACH, "touch_gap", "touch"), no_objects, _bounce),
}
