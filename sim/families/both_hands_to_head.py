"""Both hands laid on the head: three targets in a single blob."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.on_head import Laying, laid_on_head
from sim.motion.motion import MotionPlan, successive
from sim.motion.planner import curled
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD

# Where the left hand lies, in shares of the head's half axes (x out of the face, y outward, z up),
# and where its fingers point, in the head's frame.
_PLACES: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "cheeks": ((0.62, 0.72, -0.25), (-0.15, 0.0, 1.0)),
    "forehead": ((0.85, 0.45, 0.35), (0.0, -0.35, 0.9)),
    "face": ((0.95, 0.45, -0.20), (-0.1, -0.15, 1.0)),
}
_BETWEEN_M = 0.004  # from either hand to the head's mid-plane, so that tremor is not contact


def _on_head(stage: Stage, side: int) -> HandState:
    """A hand laid on its place of the head while the other is laid there too."""
    spot, fingers = np.array([1.0, OUTWARD[side], 1.0]) * _PLACES[str(stage.values["where"])]
    laying = Laying(
        spot,
        fingers,
        np.array([0.0, 0.0, -0.17 * stage.scene.anatomy.hand_breadth_m]),
        curled(stage.number("curl")),
        own_side_m=_BETWEEN_M,
        twists_rad=(0.0, 0.15, -0.15),
        tilts_rad=(0.0, 0.12, 0.25, 0.4),
    )
    # The head is where it will be while both hands follow it.
    like, other = (
        replace(
            stage.rest(hand),
            air=0.1,
            with_head=1.0,
            nod_rad=0.5 * stage.number("nod"),
            swivel_rad=stage.number("swivel"),
        )
        for hand in (side, 1 - side)
    )
    return laid_on_head(stage, side, laying, like, other)


def _both_hands_to_head(stage: Stage) -> MotionPlan:
    """Both hands go to the head, stay, and come back."""
    speed = stage.number("speed")
    hands = stage.planners()
    on = (_on_head(stage, 0), _on_head(stage, 1))
    before = [hand.moved(0.08 * (hand.rotation[:, 2] + [1, 0, 0])) for hand in on]
    begun = stage.start_s
    late = stage.number("lag")
    for side in (0, 1):
        hands[side].until(begun + (late if side == stage.side("second") else 0.0))
        # Forward of the shoulder: no elbow folds enough for the straight way.
        away = np.array([0.12, OUTWARD[side] * 0.03, 0.0])
        hands[side].move(before[side], speed, away)
        hands[side].move(on[side], 0.5 * speed)
    there = max(hand.clock_s for hand in hands)
    left = there + stage.number("hold")
    for side in (0, 1):
        hands[side].until(left)
        hands[side].move(before[side], 0.5 * speed)
        hands[side].move(stage.rest(side), speed, [0.12, OUTWARD[side] * 0.03, 0.0])
    ended = max(hand.clock_s for hand in hands)
    cues = successive(begun, ("to_head", there), ("on_head", left), ("back", ended))
    return stage.plan(hands, cues=cues)


FAMILIES: Mapping[str, Family] = {
    "both_hands_to_head": Family(
        ("where", "second", "lag", "speed", "wait", "hold", "nod", "curl", "swivel"),
        _both_hands_to_head,
    ),
}
