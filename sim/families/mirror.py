"""Hands that meet again and again, and cross or return each time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sim.families.approach import (
    PARAMETERS,
    Approach,
    Pair,
    approach,
    brake,
    during,
    lower,
    merged_shares,
    share_time,
)
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import HandPlanner
from sim.motion.stage import Family, Stage
from sim.motion.strokes import Stroke

MOST_MEETINGS = 10


def _mirror(stage: Stage) -> MotionPlan:
    """The hands meet again and again; each time a coin says whether they cross or return."""
    a = approach(stage, stage.number("bow"))
    # As many coins whatever the number of meetings, so that fewer begin like more.
    coins = stage.streams("coins").random(MOST_MEETINGS) < stage.number("cross_share")
    places, cues = (a.apart, a.crossed), []
    shares: dict[int, tuple[float, float]] = {}  # of the ways from either pair of places
    crossed = 0  # index of the pair of places at which the hands are
    for k in range(round(stage.number("meetings"))):
        if crossed not in shares:
            shares[crossed] = merged_shares(stage, a, places[crossed], places[1 - crossed])
        meet = _cross_over if coins[k] else _turn_back
        cues.append(meet(stage, a, places[crossed], places[1 - crossed], shares[crossed], k + 1))
        crossed = 1 - crossed if coins[k] else crossed
        for hand in a.hands:
            hand.wait(stage.number("pause"))
    if not crossed:
        lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def _cross_over(
    stage: Stage, a: Approach, here: Pair, there: Pair, merged: tuple[float, float], k: int
) -> Cue:
    """Add the strokes of both hands to the other side; returns their cue."""
    strokes = [a.hands[s].move(there[s], stage.number("speed"), a.bows_m[s]) for s in (0, 1)]
    return during(f"cross:{k}", strokes[0], merged)


def _turn_back(
    stage: Stage, a: Approach, here: Pair, there: Pair, merged: tuple[float, float], k: int
) -> Cue:
    """Add the same strokes, broken off where the hands merge, and the way back; returns the cue."""
    speed, further = stage.number("speed"), 0.5 * stage.number("overlap")
    share = merged[0]
    begun_s = 0.0
    for side in (0, 1):
        hand = a.hands[side]
        stroke = hand.move(there[side], speed, a.bows_m[side])
        begun_s = stroke.start_s + share_time(share) * stroke.duration_s
        stop_m = stroke.at(begun_s, here[side]).position_m.copy()
        stop_m[1] -= np.sign(stop_m[1]) * further
        brake(hand, stroke, here[side], share, stop_m)
    ended = max(hand.clock_s for hand in a.hands)
    backs = []
    for side in (0, 1):
        a.hands[side].until(ended)
        backs.append(a.hands[side].move(here[side], speed))
    return Cue(f"return:{k}", begun_s, _parted_s(backs[0], a.hands[0], further))


def _parted_s(back: Stroke, hand: HandPlanner, way_m: float) -> float:
    """When the hand, on its last stroke, has gone way_m across [s]."""
    start = hand.path().at(back.start_s).position_m
    across = abs(float(back.to.position_m[1] - start[1]))
    return back.start_s + back.duration_s * share_time(min(way_m / across, 1.0))


FAMILIES: Mapping[str, Family] = {
    "mirror": Family(
        (
            *(name for name in PARAMETERS if name not in ("hold", "merge_gap")),
            "overlap",
            "meetings",
            "cross_share",
            "pause",
        ),
        _mirror,
    ),
}
