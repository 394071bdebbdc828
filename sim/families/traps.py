"""Identity traps: what nobody can tell from positions alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.contact import capsule_gap, hand_capsules
from sim.families.crossing import (
    APPROACH,
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
from sim.motion.planner import HandPlanner, raised
from sim.motion.stage import STILL_S, Family, Stage, Values, no_objects, number
from sim.motion.strokes import Stroke
from sim.person.kinematics import OUTWARD
from sim.specs import ObjectSpec

MOST_MEETINGS = 10
_SCREEN_RGB = (0.16, 0.25, 0.24)
_TURN_S = 0.9  # to change sides behind the screen


def _mirror(stage: Stage) -> MotionPlan:
    """The hands meet again and again; each time a coin says whether they cross or return."""
    a = approach(stage, stage.number("bow"))
    # As many coins whatever the number of meetings, so that fewer begin like more.
    coins = stage.streams("coins").random(MOST_MEETINGS) < stage.number("cross_share")
    places, cues = (a.apart, a.crossed), []
    crossed = 0  # which of the two places the hands are at
    for k in range(round(stage.number("meetings"))):
        meet = _cross_over if coins[k] else _turn_back
        cues.append(meet(stage, a, places[crossed], places[1 - crossed], k + 1))
        crossed = 1 - crossed if coins[k] else crossed
        for hand in a.hands:
            hand.wait(stage.number("pause"))
    if not crossed:
        lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def _cross_over(stage: Stage, a: Approach, here: Pair, there: Pair, k: int) -> Cue:
    """Both hands to the other side."""
    strokes = [a.hands[s].move(there[s], stage.number("speed"), a.bows_m[s]) for s in (0, 1)]
    return during(f"cross:{k}", strokes[0], merged_shares(stage, a, here, there))


def _turn_back(stage: Stage, a: Approach, here: Pair, there: Pair, k: int) -> Cue:
    """The same strokes, broken off where the hands merge; they go on a little, and back."""
    speed, further = stage.number("speed"), 0.5 * stage.number("overlap")
    share = merged_shares(stage, a, here, there)[0]
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
    """When the hand, on its last stroke, has gone this far across."""
    start = hand.path().at(back.start_s).position_m
    across = abs(float(back.to.position_m[1] - start[1]))
    return back.start_s + back.duration_s * share_time(min(way_m / across, 1.0))


def _screen(values: Values) -> tuple[ObjectSpec, ...]:
    size = (0.05, number(values, "screen_width"), number(values, "screen_height"))
    place = (number(values, "screen_x"), 0.0)
    return (ObjectSpec("screen", "box", size, _SCREEN_RGB, place),)


def _swap_hidden(stage: Stage) -> MotionPlan:
    """Both hands go behind a screen, and come out crossed or not, at the same places."""
    a = approach(stage)
    speed, time_s = stage.number("speed"), stage.number("hidden")
    swapped = stage.values["outcome"] == "crossed"
    middle_m = 0.5 * (a.apart[0].position_m + a.apart[1].position_m)
    sunk_m = stage.number("height") - stage.number("hidden_height")
    turn_s = min(_TURN_S, time_s)
    for side in (0, 1):
        hand, across = a.hands[side], np.array([0.0, OUTWARD[side], 0.0])
        plane_m = np.array([0.5, 0.0, 0.5]) * (a.apart[side].position_m - middle_m)
        low = middle_m + 2.0 * plane_m + np.array([0.0, 0.0, -sunk_m])
        swivel = a.apart[side].swivel_rad
        behind = raised(side, low, 1.25, 0.0, 1.2, curl=0.3, swivel_rad=swivel)
        inside_m, out_m = stage.number("inside") * across, stage.number("past") * across
        hand.move(replace(behind, position_m=low + inside_m), speed)
        hand.wait(0.5 * (time_s - turn_s))
        if swapped:
            hand.move(replace(behind, position_m=low - inside_m), speed, least_s=turn_s)
        else:
            hand.wait(turn_s)
        hand.wait(0.5 * (time_s - turn_s))
        centre_m = a.apart[side].position_m * np.array([1.0, 0.0, 1.0])
        out = replace(a.apart[side], position_m=centre_m + (-out_m if swapped else out_m))
        hand.move(out, speed)
    went, turned = a.hands[0].moves[1], a.hands[0].moves[-1]
    sight = (Cue("hidden", went.end_s, turned.start_s),)
    name = "out:crossed" if swapped else "out:same"
    return stage.plan(a.hands, cues=(*sight, Cue(name, turned.end_s, stage.duration_s)))


def _beside(stage: Stage, centre_m: Floats, gap_m: float) -> Pair:
    """Both hands palm down at centre_m (3,), as far from each other as leaves gap_m between."""

    def places(half_m: float) -> Pair:
        right, left = (
            raised(
                side,
                centre_m + np.array([0.0, OUTWARD[side] * half_m, 0.0]),
                stage.number("inward"),
                -0.1,
                0.25,
                curl=0.12,
            )
            for side in (0, 1)
        )
        return right, left

    low, high = 0.0, 0.4
    for _ in range(20):
        half = 0.5 * (low + high)
        bars = [
            hand_capsules(stage.scene.anatomy, side, state.curls).placed(
                state.position_m, state.rotation
            )
            for side, state in enumerate(places(half))
        ]
        low, high = (low, half) if -capsule_gap(bars[0], bars[1])[0] > gap_m else (half, high)
    return places(high)


def _parallel(stage: Stage) -> MotionPlan:
    """The hands come side by side, go the same ways together, and part."""
    rng, speed = stage.streams("paths"), stage.number("speed")
    centre = np.array(
        [stage.number("centre_x"), 0.0, stage.scene.room.table_height_m + stage.number("height")]
    )
    pair = _beside(stage, centre, stage.number("gap"))
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    for hand in hands:
        hand.until(STILL_S + stage.number("wait"))

    def together(shift_m: Floats, bow_m: Floats, pause_s: float) -> None:
        for side in (0, 1):
            state = pair[side]
            hands[side].move(replace(state, position_m=state.position_m + shift_m), speed, bow_m)
        ready = max(hand.clock_s for hand in hands)
        for hand in hands:
            hand.until(ready + pause_s)

    reach = stage.number("reach") * np.array([0.3, 1.0, 0.4])
    side_to_side = 1.0 if rng.random() < 0.5 else -1.0
    together(np.zeros(3), np.array([0.0, 0.0, 0.02]), 0.2)
    joined = hands[0].clock_s
    for _ in range(round(stage.number("strokes"))):
        # From side to side, so that every stroke is a long one.
        shift = reach * rng.uniform((-1.0, 0.5, -1.0), 1.0) * np.array([1.0, side_to_side, 1.0])
        bow = 0.02 * rng.uniform(-1.0, 1.0, 3)
        together(shift, bow, float(rng.uniform(0.0, 0.4)))
        side_to_side = -side_to_side
    together(np.zeros(3), np.zeros(3), 0.1)
    parted = hands[0].clock_s
    for side in (0, 1):
        hands[side].move(stage.rest(side), speed, [0.0, 0.0, 0.02])
    ended = max(hand.clock_s for hand in hands)
    return stage.plan(hands, cues=(Cue("parallel", joined, parted), Cue("part", parted, ended)))


FAMILIES: Mapping[str, Family] = {
    "mirror": Family(
        (
            *(name for name in APPROACH if name not in ("hold", "merge_gap")),
            "overlap",
            "meetings",
            "cross_share",
            "pause",
        ),
        no_objects,
        _mirror,
    ),
    "swap_hidden": Family(
        (
            *(name for name in APPROACH if name not in ("hold", "merge_gap", "bow")),
            "hidden",
            "hidden_height",
            "inside",
            "outcome",
            "screen_x",
            "screen_width",
            "screen_height",
        ),
        _screen,
        _swap_hidden,
    ),
    "parallel": Family(
        (
            "speed",
            "gap",
            "strokes",
            "reach",
            "inward",
            "height",
            "centre_x",
            "wait",
        ),
        no_objects,
        _parallel,
    ),
}
