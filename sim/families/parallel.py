"""Hands that go side by side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.capsules import capsule_gap
from sim.families.approach import (
    Pair,
)
from sim.families.touching import hand_bars
from sim.motion.bisection import bisect
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import RISING_M, meet, raised
from sim.motion.stage import Family, Stage
from sim.person.kinematics import OUTWARD


def _beside(stage: Stage, centre_m: Floats, gap_m: float) -> Pair:
    """Both hands palm down about centre_m (3,), with gap_m of air between them."""

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

    def apart(half_m: float) -> bool:
        right, left = (
            hand_bars(stage.scene.anatomy, side, state) for side, state in enumerate(places(half_m))
        )
        return -capsule_gap(right, left)[0] > gap_m

    return places(bisect(0.0, 0.4, 20, apart)[1])


def _parallel(stage: Stage) -> MotionPlan:
    """The hands come side by side, go the same ways together, and part."""
    rng, speed = stage.streams("paths"), stage.number("speed")
    pair = _beside(stage, stage.centre_m, stage.number("gap"))
    hands = stage.planners(stage.start_s)

    def together(shift_m: Floats, bow_m: Floats, pause_s: float) -> None:
        for side in (0, 1):
            hands[side].move(pair[side].moved(shift_m), speed, bow_m)
        meet(hands, pause_s)

    reach = stage.number("reach") * np.array([0.3, 1.0, 0.4])
    side_to_side = 1.0 if rng.random() < 0.5 else -1.0
    together(np.zeros(3), RISING_M, 0.2)
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
        hands[side].move(stage.rest(side), speed, RISING_M)
    ended = max(hand.clock_s for hand in hands)
    return stage.plan(hands, cues=(Cue("parallel", joined, parted), Cue("part", parted, ended)))


FAMILIES: Mapping[str, Family] = {
    "parallel": Family(
        ("speed", "gap", "strokes", "reach", "inward", "height", "centre_x", "wait"), _parallel
    ),
}
