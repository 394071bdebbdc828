"""Cross and bounce: the same approach, two outcomes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.arm_shape import hand_capsules
from sim.contact.capsules import capsule_gap
from sim.families.approach import (
    PARAMETERS,
    Approach,
    approach,
    brake,
    during,
    lower,
    merged_shares,
)
from sim.motion.bisection import bisect
from sim.motion.motion import Cue, MotionPlan
from sim.motion.stage import Family, Stage
from sim.person.kinematics import OUTWARD


def _merging(stage: Stage, a: Approach) -> tuple[float, float]:
    """Shares of the crossing's way at which the hands merge, and part.

    They merge where both pictures show it, and not before their palms are merge_gap apart.
    """
    spread, past = stage.number("spread"), stage.number("past")
    first, last = merged_shares(stage, a, a.apart, a.crossed)
    first = max(first, (spread - 0.5 * stage.number("merge_gap")) / (spread + past))
    return first, max(first, last)


def _cross(stage: Stage) -> MotionPlan:
    """The hands pass each other, stay crossed, and go back if the parameter `back` says so."""
    a = approach(stage, stage.number("bow"))
    cues = crossing(stage, a)
    if stage.values["back"] == "yes":
        for hand in a.hands:
            hand.wait(0.4)
        lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def crossing(stage: Stage, a: Approach) -> list[Cue]:
    """Add the moves of hands that pass each other, stay crossed and may go back; returns cues."""
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
    return cues


def _touching(stage: Stage, a: Approach) -> tuple[Floats, Floats]:
    """Palms (right, left), each (3,) [m], of hands laid over each other that just touch.

    They are touch_gap apart across, and along the depth as little as keeps them from overlapping.
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

    def clear(gap_m: float) -> bool:
        bars = [shapes[s].placed(places(gap_m)[s], a.apart[s].rotation) for s in (0, 1)]
        return capsule_gap(bars[0], bars[1])[0] <= 0.0

    return places(bisect(0.0, 0.25, 20, clear)[1])


def _bounce(stage: Stage) -> MotionPlan:
    """The same approach, but where the hands would merge they brake, touch and return."""
    a = approach(stage, stage.number("bow"))
    cues = bouncing(stage, a)
    for hand in a.hands:
        hand.wait(stage.number("hold"))
    lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def bouncing(stage: Stage, a: Approach) -> list[Cue]:
    """Add the moves of hands that approach, touch and return; returns their cues."""
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
    return cues


FAMILIES: Mapping[str, Family] = {
    "cross": Family((*PARAMETERS, "back"), _cross),
    "bounce": Family((*PARAMETERS, "touch_gap", "touch"), _bounce),
}
