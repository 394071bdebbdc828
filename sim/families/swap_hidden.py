"""Hands that swap behind a screen, or do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.approach import (
    PARAMETERS,
    approach,
)
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import raised
from sim.motion.stage import Family, Stage, Values, number
from sim.person.kinematics import OUTWARD
from sim.specs import ObjectSpec

_SCREEN_RGB = (0.16, 0.25, 0.24)

_TURN_S = 0.9  # to change sides behind the screen


def _screen(values: Values) -> tuple[ObjectSpec, ...]:
    size = (0.05, number(values, "screen_width"), number(values, "screen_height"))
    place = (number(values, "screen_x"), 0.0)
    return (ObjectSpec("screen", "box", size, _SCREEN_RGB, place),)


def _swap_hidden(stage: Stage) -> MotionPlan:
    """Both hands go behind a screen, and come out at the same places, swapped or not."""
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
        hand.move(behind.moved(inside_m), speed)
        hand.wait(0.5 * (time_s - turn_s))
        if swapped:
            hand.move(behind.moved(-inside_m), speed, least_s=turn_s)
        else:
            hand.wait(turn_s)
        hand.wait(0.5 * (time_s - turn_s))
        centre_m = a.apart[side].position_m * np.array([1.0, 0.0, 1.0])
        out = replace(a.apart[side], position_m=centre_m + (-out_m if swapped else out_m))
        hand.move(out, speed)
    went, turned = a.hands[0].moves[1], a.hands[0].moves[-1]
    hidden = Cue("hidden", went.end_s, turned.start_s)
    outcome = "out:crossed" if swapped else "out:same"
    return stage.plan(a.hands, cues=(hidden, Cue(outcome, turned.end_s, stage.duration_s)))


FAMILIES: Mapping[str, Family] = {
    "swap_hidden": Family(
        (
            *(name for name in PARAMETERS if name not in ("hold", "merge_gap", "bow")),
            "hidden",
            "hidden_height",
            "inside",
            "outcome",
            "screen_x",
            "screen_width",
            "screen_height",
        ),
        _swap_hidden,
        _screen,
    ),
}
