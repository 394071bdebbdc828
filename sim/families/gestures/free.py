"""Gestures of an empty hand in the air or on the table: rest, reach, point, wave, circle, stay."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.arm_shape import height_above_table
from sim.contact.contact import Unposable
from sim.families.gestures.gesture import (
    ANY_LOAD,
    BOTH,
    DURATION,
    HAND,
    SPEED,
    Gesture,
    Place,
    Quantity,
    Step,
    Target,
    Word,
)
from sim.families.gestures.legs import Leg, lay
from sim.families.gestures.rehearsal import Rehearsal
from sim.families.gestures.targets import point_of
from sim.motion.curves import ellipse, rounds
from sim.motion.planner import RISING_M, curled, raised
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.vectors import norm

_TABLE_M = 1e-3  # of air under a hand that lies on the table
_RAMP_S = 0.4  # in which rounds get going, and come to rest
_POINTING = (0.35, 0.0, 0.75, 0.8, 0.85)  # curls


def _rest(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """Back to the hand's place on the table, or beside it."""
    to = rehearsal.stage.rest(side, step.number("ahead"), step.number("outward"))
    lay(rehearsal.hands[side], [Leg((to,), bulge_m=(0.0, 0.0, 0.03))], step)


def _reach(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The palm goes to a target: flat on the table where that is its height, else as turned."""
    hand, stage = rehearsal.hands[side], rehearsal.stage
    target = step.targets["to"]
    point = point_of(rehearsal, target, side)
    if target.kind == "table" and target.offset_m[2] == 0.0:
        rotation = hand_rotation(side, step.number("inward"), math.radians(2), math.radians(4))
        curls = curled(step.number("curl"), thumb=0.1)
        lies = height_above_table(stage.scene.anatomy, side, rotation, curls) + _TABLE_M
        to = HandState(point + np.array([0.0, 0.0, lies]), quaternion_of(rotation), curls)
    else:
        turns = (step.number("inward"), step.number("down"), step.number("thumb_up"))
        to = raised(side, point, *turns, curl=step.number("curl"))
        to = replace(to, swivel_rad=step.number("elbow_out"))
    rising = hand.state.air == 0.0 or to.air == 0.0
    lay(hand, [Leg((to,), bulge_m=RISING_M if rising else np.zeros(3))], step)
    hand.wait(step.number("hold"))


def _point(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hand rises, the index finger straight and in line with the target."""
    palm = point_of(rehearsal, step.targets["palm"], side)
    way = point_of(rehearsal, step.targets["to"], side) - palm
    if norm(way) < 0.1:
        raise Unposable(
            f"{step.where}: to: the target is less than 10 cm from the palm that points to it; "
            "move `palm` away from it"
        )
    inward = -OUTWARD[side] * math.atan2(way[1], way[0])
    down = math.atan2(-way[2], math.hypot(way[0], way[1]))
    to = raised(side, palm, inward, down, step.number("thumb_up"))
    to = replace(to, curls=np.array(_POINTING))
    hand = rehearsal.hands[side]
    lay(hand, [Leg((to,), bulge_m=RISING_M)], step)
    hand.wait(step.number("hold"))


def _wave(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hand rises, palm to the cameras, and swings from side to side."""
    hand = rehearsal.hands[side]
    place = point_of(rehearsal, step.targets["to"], side)
    up = raised(side, place, 0.1, -1.25, 0.0, curl=0.06, swivel_rad=0.2)
    half = 0.5 * step.number("size")
    # From the middle outward first, a little lower at both ends.
    aside = np.array([0.0, OUTWARD[side] * half, 0.0])
    lay(hand, [Leg((up,), bulge_m=RISING_M)], step.without_duration())
    _swing(rehearsal, step, side, aside, np.array([0.0, 0.0, 0.12 * half]))


def _circle(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """Rounds about a point beside the hand, from where the hand is."""
    half = 0.5 * step.number("size")
    turn = 1.0 if step.words["way"] == "inward" else -1.0
    first = half * np.array([1.0, 0.0, 0.0] if step.words["plane"] == "level" else [0.0, 0.0, 1.0])
    second = half * np.array([0.0, -turn * OUTWARD[side], 0.0])
    _swing(rehearsal, step, side, first, second)


def _swing(rehearsal: Rehearsal, step: Step, side: int, first: Floats, second: Floats) -> None:
    """Rounds of an ellipse of these half axes (3,) for the step's duration."""
    hand, seconds = rehearsal.hands[side], step.number("duration")
    curve = ellipse(first, second, np.zeros(3))
    ramp_s = min(_RAMP_S, 0.45 * seconds)
    hand.add(rounds(hand.clock_s, hand.state, curve, step.number("rate"), seconds, ramp_s))


def _stay(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The hand stays as it is."""
    rehearsal.hands[side].wait(step.number("duration"))


_HOLD = Quantity("hold", "s", 0.0, 600.0, "how long it stays there", 0.0)
_TURNS = (
    Quantity("inward", "rad", -0.8, 1.6, "fingers turned to the mid-plane", 0.35),
    Quantity("down", "rad", -1.5, 1.2, "finger tips dipped", 0.0),
    Quantity("thumb_up", "rad", -0.5, 1.7, "thumb rolled up; pi/2: palm inward", 0.4),
    Quantity("curl", "1", 0.0, 0.9, "curl of the fingers; 1 a fist", 0.12),
    Quantity("elbow_out", "rad", -0.5, 1.2, "elbow outward beyond the person's habit", 0.0),
)
_FRONT = Target("table", "", (0.38, 0.20, 0.20))
_UP = Target("table", "", (0.36, 0.30, 0.34))
DEFAULT_TARGETS = {("point", "palm"): _FRONT, ("wave", "to"): _UP}
_EACH = (HAND, BOTH)
GESTURES = {
    "rest": Gesture(
        "lies down flat at the hand's place on the table",
        (
            SPEED,
            DURATION,
            Quantity("ahead", "m", -0.15, 0.3, "beside that place: ahead", 0.0),
            Quantity("outward", "m", -0.2, 0.3, "beside that place: outward", 0.0),
        ),
        _rest,
        _EACH,
    ),
    "reach": Gesture(
        "goes with the palm to a target and stays",
        (Place("to", "where the palm goes"), SPEED, DURATION, _HOLD, *_TURNS),
        _reach,
        _EACH,
    ),
    "point": Gesture(
        "points with the index finger to a target",
        (
            Place("to", "what it points to"),
            Place("palm", "where the palm is meanwhile; before the shoulder", required=False),
            SPEED,
            DURATION,
            _HOLD,
            Quantity("thumb_up", "rad", -0.5, 1.7, "thumb rolled up", 0.5),
        ),
        _point,
    ),
    "wave": Gesture(
        "rises with the palm to the cameras and swings",
        (
            Place("to", "where it waves; beside the face", required=False),
            Quantity("speed", "m/s", 0.02, 4.0, "peak speed of rising", 0.4),
            Quantity("size", "m", 0.02, 0.4, "from side to side", 0.16),
            Quantity("rate", "Hz", 0.2, 4.0, "how fast it swings", 1.2),
            Quantity("duration", "s", 0.5, 600.0, "how long it swings", 2.0),
        ),
        _wave,
        _EACH,
    ),
    "circle": Gesture(
        "goes round and round from where it is, also with an object",
        (
            Quantity("size", "m", 0.01, 0.4, "across", 0.10),
            Quantity("rate", "Hz", 0.1, 3.0, "rounds a second", 0.6),
            Quantity("duration", "s", 0.5, 600.0, "how long", 3.0),
            Word("plane", ("level", "upright"), "of the circle", "level"),
            Word("way", ("inward", "outward"), "which way it begins", "inward"),
        ),
        _circle,
        _EACH,
        ANY_LOAD,
    ),
    "stay": Gesture(
        "stays as it is, also with an object",
        (Quantity("duration", "s", 0.0, 600.0, "how long", required=True),),
        _stay,
        _EACH,
        ANY_LOAD,
    ),
}
