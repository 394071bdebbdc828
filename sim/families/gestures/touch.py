"""Gestures of a hand that touches the person: the face, the head, the other hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.gestures.gesture import DURATION, SPEED, Gesture, Quantity, Step, Word
from sim.families.gestures.legs import Leg, lay
from sim.families.gestures.rehearsal import Rehearsal
from sim.families.on_head import Laying, laid_alone
from sim.families.touch_face import SPOTS, before_face, on_face
from sim.families.touching import brought, hand_bars
from sim.motion.planner import RISING_M, curled, raised
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD
from sim.vectors import norm

OTHER_HAND = "other_hand"
# Where a hand lies on the head beyond the face, towards its own side, and where its fingers point.
_ON_HEAD: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "crown": ((0.35, 0.25, 0.90), (-0.2, -0.9, 0.2)),
    "temple": ((0.45, 0.90, 0.20), (-0.3, 0.0, 1.0)),
}
WHAT = (*SPOTS, *_ON_HEAD, OTHER_HAND)
_CLEAR_M = 0.09  # from which a hand comes down on the other


def _touch(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hand goes there, stays and comes off again, into the air before it."""
    hand = rehearsal.hands[side]
    if step.words["what"] == OTHER_HAND:
        # The other hand stays as it is until this is over.
        rehearsal.hands[1 - side].until(hand.clock_s)
        hand.until(rehearsal.hands[1 - side].clock_s)
        way = _onto_other_hand(rehearsal, side)
    else:
        way = _onto_head(rehearsal, step, side)
    *before, _ = way
    lay(hand, [Leg(tuple(way))], step)
    hand.wait(step.number("hold"))
    lay(hand, [Leg(tuple(reversed(before)))], step.without_duration())
    if step.words["what"] == OTHER_HAND:
        rehearsal.hands[1 - side].until(hand.clock_s)


def _onto_head(rehearsal: Rehearsal, step: Step, side: int) -> tuple[HandState, ...]:
    """States from before the head to where the hand touches it."""
    stage = rehearsal.stage_of(step)
    what = step.words["what"]
    if what in SPOTS:
        on = on_face(stage, side, what, np.zeros(3))
    else:
        mirror = np.array([1.0, OUTWARD[side], 1.0])
        spot, fingers = (mirror * np.array(v) for v in _ON_HEAD[what])
        anatomy = stage.scene.anatomy
        pad = np.array([0.30 * anatomy.hand_length_m, 0.0, -0.10 * anatomy.hand_breadth_m])
        laying = Laying(spot, fingers, pad, curled(0.2, thumb=0.15))
        on = laid_alone(stage, side, laying, stage.number("elbow_out"))
    return (*before_face(side, rehearsal.stage.rest(side), on), on)


def _onto_other_hand(rehearsal: Rehearsal, side: int) -> tuple[HandState, ...]:
    """States from above the other hand, as it is now, to where this hand lies on it."""
    anatomy, other = rehearsal.stage.scene.anatomy, rehearsal.hands[1 - side].state
    # Across the other hand, the fingers past it, so that the forearms do not meet.
    place = other.position_m + np.array([-0.02, 0.0, 0.05])
    over = raised(side, place, 0.9, 0.15, 0.1, curl=0.12)
    on = brought(
        anatomy, side, over, np.array([0.0, 0.0, -1.0]), hand_bars(anatomy, 1 - side, other)
    )
    on = replace(on, air=0.0, swivel_rad=0.3)
    above = replace(on.moved([-0.02, 0.0, _CLEAR_M]), air=1.0)
    here = rehearsal.hands[side].state.position_m
    if norm(here - above.position_m) < 0.02:  # a sweep's stops must differ
        return above, on
    half = 0.5 * (here + above.position_m) + 2.0 * RISING_M
    return replace(above, position_m=half), above, on


GESTURES = {
    "touch": Gesture(
        "touches face, head or the other hand, stays, and comes off",
        (
            Word("what", WHAT, "what it touches"),
            SPEED,
            DURATION,
            Quantity("hold", "s", 0.0, 600.0, "how long it stays", 1.0),
            Quantity("elbow_out", "rad", 0.0, 0.6, "elbow out beyond the person's habit", 0.2),
        ),
        _touch,
    ),
}
