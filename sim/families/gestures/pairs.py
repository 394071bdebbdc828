"""Gestures of both hands together: cross, bounce, clasp."""

from __future__ import annotations

from sim.families.approach import approach
from sim.families.crossing import bouncing, crossing
from sim.families.gestures.gesture import BOTH, Gesture, Quantity, Step, Word
from sim.families.gestures.rehearsal import Rehearsal
from sim.families.merge_and_hold import clasped


def _cross(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hands rise, pass each other, stay crossed, and go back to their sides."""
    stage = rehearsal.stage_of(step)
    rehearsal.cues += crossing(stage, approach(stage, stage.number("bow"), rehearsal.hands))


def _bounce(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hands rise, meet as if they were to cross, touch, and go back to their sides."""
    stage = rehearsal.stage_of(step)
    rehearsal.cues += bouncing(stage, approach(stage, stage.number("bow"), rehearsal.hands))


def _clasp(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """A fist is laid into the other hand, which closes round it; they stay, and part."""
    rehearsal.cues += clasped(rehearsal.stage_of(step), rehearsal.hands)


# Middles of the nominal ranges of the scenarios `cross` and `merge_and_hold`.
_MEETING = (
    Quantity("raise_speed", "m/s", 0.1, 1.5, "peak speed of raising the hands", 0.35),
    Quantity("height", "m", 0.10, 0.40, "where they meet, above the table", 0.21),
    Quantity("centre_x", "m", 0.25, 0.50, "where they meet, ahead of the shoulders", 0.34),
)
_PASSING = (
    Quantity("speed", "m/s", 0.05, 3.0, "peak speed across the middle", 0.25),
    *_MEETING,
    Quantity("depth_gap", "m", 0.03, 0.20, "distance of the palms along the depth", 0.09),
    Word("front", ("right", "left"), "the hand nearer to the cameras", "right"),
    Quantity("spread", "m", 0.15, 0.30, "palms from the mid-plane before", 0.22),
    Quantity("past", "m", 0.05, 0.22, "how far each goes past the mid-plane", 0.135),
    Quantity("bow", "m", -0.03, 0.05, "bow of the paths along the depth", 0.01),
    Quantity("merge_gap", "m", 0.10, 0.30, "across, at which the hands begin to merge", 0.14),
)
GESTURES = {
    "cross": Gesture(
        "both hands pass each other before the chest",
        (
            *_PASSING,
            Quantity("hold", "s", 0.0, 600.0, "how long they stay crossed", 0.5),
            Word("back", ("yes", "no"), "whether they cross back", "yes"),
        ),
        _cross,
        (BOTH,),
    ),
    "bounce": Gesture(
        "both hands meet as if to cross, touch and turn back",
        (
            *_PASSING,
            Quantity("touch_gap", "m", 0.0, 0.15, "palms apart across as they touch", 0.05),
            Quantity("touch", "s", 0.0, 60.0, "how long they touch", 0.3),
        ),
        _bounce,
        (BOTH,),
    ),
    "clasp": Gesture(
        "a fist is laid into the other hand, which closes round it",
        (
            Quantity("speed", "m/s", 0.05, 1.5, "peak speed of coming together", 0.25),
            *_MEETING,
            Word("outer", ("right", "left"), "the hand that closes round the other", "right"),
            Quantity("apart", "m", 0.15, 0.45, "palms apart before and after", 0.26),
            Quantity("drift", "m", 0.0, 0.08, "how far they wander while clasped", 0.02),
            Quantity("hold", "s", 0.1, 600.0, "how long they stay clasped", 1.5),
        ),
        _clasp,
        (BOTH,),
    ),
}
