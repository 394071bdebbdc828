"""Gestures with an object: grasp, lift, carry, put."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim.contact.contact import Unposable
from sim.families.at_mouth import held_at_mouth
from sim.families.gestures.gesture import (
    DURATION,
    LOADED,
    PUTS,
    SPEED,
    TAKES,
    Gesture,
    ObjectName,
    Place,
    Quantity,
    Step,
    Target,
)
from sim.families.gestures.legs import Leg, lay
from sim.families.gestures.rehearsal import Load, Rehearsal
from sim.families.gestures.targets import outward, point_of
from sim.families.touching import closed, object_bars
from sim.motion.motion import Hold
from sim.motion.planner import LEAST_STROKE_S, curled, grasp
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD
from sim.pose import Transform

_NEAR = 0.5  # share of the peak speed on the last piece of the way to an object
_CLOSING_S = 0.4  # least time of closing or opening a hand
_WIDEST_M = 0.12  # that a hand closes on
_CLOSED_ON = ("cup", "box", "ball")  # objects on which fingers are closed one by one


def _grasp(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """Reach for an object from outside, open, and close the hand round it."""
    name = step.words["object"]
    spec, place = rehearsal.object_named(name)
    if min(spec.size_m[:2]) > _WIDEST_M:
        raise Unposable(
            f"{step.where}: object: {name} is {1000 * min(spec.size_m[:2]):.0f} mm wide, too wide "
            f"for a hand (at most {1000 * _WIDEST_M:.0f} mm); make it smaller"
        )
    scene = rehearsal.stage.scene
    taking = grasp(scene, side, spec, place)
    if spec.kind in _CLOSED_ON:
        bars = object_bars(spec, place)
        gripped = closed(scene.anatomy, side, taking.open, curled(0.7, thumb=0.7), bars)
        taking = replace(taking, closed=gripped)
    hand = rehearsal.hands[side]
    legs = [
        Leg((taking.before,), bulge_m=(0.0, 0.0, 0.03)),
        Leg((taking.open,), _NEAR),
        Leg((taking.closed,), least_s=_CLOSING_S),
    ]
    lay(hand, legs, step)
    rehearsal.loads[side] = Load(spec, taking, place, hand.clock_s)


def _lift(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """Straight up, as the hand is."""
    hand = rehearsal.hands[side]
    to = replace(hand.state.moved([0.0, 0.0, step.number("up")]), air=1.0)
    lay(hand, [Leg((to,))], step)


def _carry(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """The object's foot goes to a target; at the mouth its rim, with the top to the face."""
    load, hand = rehearsal.loads[side], rehearsal.hands[side]
    target = step.targets["to"]
    away = np.array([0.03, OUTWARD[side] * 0.03, 0.0])
    if target.kind == "body" and target.name == "mouth":
        to = held_at_mouth(
            rehearsal.stage, side, load.grasp.closed, load.spec, load.place, step.number("tilt")
        )
        to = to.moved(outward(side, target.offset_m))
    else:
        moved = point_of(rehearsal, target, side) - load.place.position_m
        to = replace(load.grasp.closed.moved(moved), air=1.0)
    # From one place at the mouth to another there is nothing to go round.
    bow = np.zeros(3) if hand.state.with_head == to.with_head == 1.0 else away
    least = step.numbers.get("least", LEAST_STROKE_S)
    lay(hand, [Leg((to,), bulge_m=bow, least_s=least)], step)
    hand.wait(step.number("hold"))


def _put(rehearsal: Rehearsal, step: Step, side: int) -> None:
    """Set the object down flat on the table, open the hand, draw it back."""
    load, hand = rehearsal.loads.pop(side), rehearsal.hands[side]
    name = load.spec.name
    target = step.targets.get("to", Target("object", name, (0.0, 0.0, 0.0)))
    if target.kind == "object" and target.name == name:  # from where it was taken
        moved = outward(side, target.offset_m)
    else:
        moved = point_of(rehearsal, target, side) - load.place.position_m
    moved[2] = 0.0
    away = np.array([0.03, OUTWARD[side] * 0.03, 0.0])
    down: HandState = load.grasp.closed.moved(moved)
    lay(hand, [Leg((down,), bulge_m=away)], step)
    put_s = hand.clock_s
    opened = replace(down, curls=load.grasp.open.curls)
    speed = step.number("release_speed")
    hand.move(opened, speed, least_s=_CLOSING_S)
    hand.move(load.grasp.before.moved(moved), speed)
    rehearsal.holds.append(Hold(name, side, load.from_s, put_s))
    stands = load.place.position_m + moved
    rehearsal.places[name] = Transform(stands, load.place.rotation)


GESTURES = {
    "grasp": Gesture(
        "reaches for an object and closes round it",
        (ObjectName("object", "what it takes"), SPEED, DURATION),
        _grasp,
        load=TAKES,
    ),
    "lift": Gesture(
        "lifts what it holds straight up",
        (Quantity("up", "m", 0.005, 0.5, "how far", 0.08), SPEED, DURATION),
        _lift,
        load=LOADED,
    ),
    "carry": Gesture(
        "carries what it holds to a target and stays; to the mouth: drinks",
        (
            Place("to", "where the object's foot goes; mouth: its rim"),
            SPEED,
            DURATION,
            Quantity("least", "s", 0.0, 60.0, "least time of the way, however short"),
            Quantity("tilt", "rad", 0.0, 1.2, "at the mouth: how far the top leans to it", 0.6),
            Quantity("hold", "s", 0.0, 600.0, "how long it stays there", 0.0),
        ),
        _carry,
        load=LOADED,
    ),
    "put": Gesture(
        "sets down what it holds on the table and draws back",
        (
            Place("to", "where; where it was taken", required=False, body=False),
            SPEED,
            DURATION,
            Quantity("release_speed", "m/s", 0.02, 2.0, "peak speed of drawing back", 0.25),
        ),
        _put,
        load=PUTS,
    ),
}
