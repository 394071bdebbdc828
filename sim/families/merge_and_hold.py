"""A hand clasped in the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.touching import brought, closed, hand_bars
from sim.motion.motion import Cue, MotionPlan, successive
from sim.motion.planner import RISING_M, HandPlanner, curled, meet, raised
from sim.motion.stage import Family, Stage
from sim.person.kinematics import OUTWARD


def _merge_and_hold(stage: Stage) -> MotionPlan:
    """The hands are clasped, part, and rest."""
    hands = stage.planners(stage.start_s)
    cues = clasped(stage, hands)
    for side in (0, 1):
        hands[side].move(stage.rest(side), stage.number("raise_speed"), RISING_M)
    return stage.plan(hands, cues=cues)


def clasped(stage: Stage, hands: tuple[HandPlanner, HandPlanner]) -> tuple[Cue, ...]:
    """Add the moves by which a fist is laid into the other hand, which closes round it, and back.

    They stay, and part. Returns the cues.
    """
    speed, outer = stage.number("speed"), stage.side("outer")
    inner, rng = 1 - outer, stage.streams("drift")
    anatomy = stage.scene.anatomy
    centre = stage.centre_m
    fist = raised(inner, centre, 0.85, -0.1, 1.25, swivel_rad=0.1)
    fist = replace(fist, curls=curled(0.78, thumb=0.5), air=0.0)
    way = fist.rotation[:, 0]  # into the other palm, knuckles first
    palm = raised(outer, centre, 0.6, -0.15, 1.45, curl=0.12, swivel_rad=0.1)
    # The knuckles meet the middle of the palm and the roots of its fingers.
    knuckles = centre + 0.03 * way
    palm = replace(palm, air=0.0, position_m=knuckles - 0.012 * palm.rotation[:, 0])
    closed_fist = hand_bars(anatomy, inner, fist)
    touching = brought(anatomy, outer, palm, -way, closed_fist)
    most = curled(0.62, thumb=0.6)
    clasp = closed(anatomy, outer, touching, most, closed_fist)
    apart = 0.5 * stage.number("apart")
    aside = np.array([0.0, apart, 0.0])
    begun = hands[0].clock_s
    for side, state in ((inner, fist), (outer, touching)):
        ready = replace(state.moved(OUTWARD[side] * aside), air=1.0)
        hands[side].move(replace(ready, curls=curled(0.2)), stage.number("raise_speed"), RISING_M)
    meet(hands, 0.3)
    hands[inner].move(fist, speed, least_s=0.5)
    hands[outer].move(touching, speed, least_s=0.5)
    meet(hands)
    hands[outer].move(clasp, speed, least_s=0.35)
    closed_s = meet(hands)
    drift = stage.number("drift") * rng.uniform(-1.0, 1.0, 3) * np.array([0.5, 1.0, 0.7])
    hold_s = stage.number("hold")
    for side, state in ((inner, fist), (outer, clasp)):
        hands[side].move(state.moved(drift), 1.0, least_s=hold_s)
    opening = meet(hands)
    hands[outer].move(touching.moved(drift), speed, least_s=0.3)
    meet(hands)
    for side, state in ((inner, fist), (outer, touching)):
        away = state.moved(drift + OUTWARD[side] * aside)
        hands[side].move(replace(away, curls=curled(0.2), air=1.0), speed, least_s=0.5)
    parted = meet(hands, 0.3)
    return successive(begun, ("come_together", closed_s), ("clasp", opening), ("part", parted))


FAMILIES: Mapping[str, Family] = {
    "merge_and_hold": Family(
        ("outer", "hold", "speed", "raise_speed", "apart", "drift", "height", "centre_x", "wait"),
        _merge_and_hold,
    ),
}
