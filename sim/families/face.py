"""Hand and head: one covers the other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.things import CAN
from sim.kinematics import OUTWARD, about_y, about_z
from sim.motion import Cue, Hold, Plan, object_at_rest, posture
from sim.planner import HandPlanner, grasp
from sim.pose import Transform
from sim.specs import ObjectSpec
from sim.stage import STILL_S, Gesture, Stage, Values, number, side_of
from sim.strokes import HandState, quaternion_of


def _drink_objects(values: Values) -> tuple[ObjectSpec, ...]:
    outward = OUTWARD[side_of(values, "hand")]
    place = (number(values, "can_x"), outward * number(values, "can_y"))
    return (ObjectSpec("can", "can", CAN, (0.72, 0.05, 0.05), place),)


def _at_mouth(
    stage: Stage, side: int, closed: HandState, can: ObjectSpec, place: Transform, tilt_rad: float
) -> HandState:
    """The hand that holds the can, taken at `closed` from `place`, with its rim at the mouth.

    tilt_rad: how far the can's top leans towards the face.
    """
    anatomy, inward = stage.scene.anatomy, -OUTWARD[side]
    nod = -0.25 * tilt_rad
    guess = replace(closed, air=1.0, with_head=1.0, nod_rad=nod)
    other = stage.rest(1 - side)
    _, head = posture(anatomy, (guess, other) if side == 0 else (other, guess), np.zeros(3))
    lips = np.array([0.43 * anatomy.head_depth_m, 0.0, -0.26 * anatomy.head_height_m])
    mouth = head.position_m + head.rotation @ lips
    # The can turns with the hand about its own axis by 0.75 rad: fingers across the face.
    can_turn = about_y(-tilt_rad) @ about_z(inward * 0.75) @ place.rotation
    up, towards = can_turn[:, 2], np.array([-math.cos(tilt_rad), 0.0, -math.sin(tilt_rad)])
    radius, tall = 0.5 * can.size_m[0], can.size_m[2]
    base = mouth - tall * up - (0.85 * radius) * towards
    hand_in_can = place.rotation.T @ (closed.position_m - place.position_m)
    turn = can_turn @ place.rotation.T @ closed.rotation
    return HandState(
        base + can_turn @ hand_in_can,
        quaternion_of(turn),
        closed.curls,
        air=0.5,
        with_head=1.0,
        nod_rad=nod,
        swivel_rad=0.45,
    )


def _drink(stage: Stage) -> Plan:
    """Reach for the can, drink, put it back, and rest."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward = OUTWARD[side]
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand = hands[side]
    can = stage.scene.room.objects[0]
    place = object_at_rest(stage.scene.room, can.name)
    taking = grasp(stage.scene, side, can, place)
    hand.until(STILL_S + stage.number("wait"))
    begun = hand.clock_s
    hand.move(taking.before, speed, [0.0, 0.0, 0.03])
    hand.move(taking.open, 0.5 * speed)
    hand.move(taking.closed, speed, least_s=0.4)
    taken = hand.clock_s
    arriving = _at_mouth(stage, side, taking.closed, can, place, 0.3)
    drinking = _at_mouth(stage, side, taking.closed, can, place, stage.number("tilt"))
    away = np.array([0.03, outward * 0.03, 0.0])
    hand.move(arriving, speed, away)
    at_mouth = hand.clock_s
    hand.move(drinking, speed, least_s=0.6)
    hand.wait(stage.number("hold"))
    hand.move(arriving, speed, least_s=0.5)
    leaving = hand.clock_s
    moved = np.array([stage.number("put_dx"), outward * stage.number("put_dy"), 0.0])
    put = replace(taking.closed, position_m=taking.closed.position_m + moved)
    hand.move(put, 0.85 * speed, away)
    put_s = hand.clock_s
    hand.move(replace(put, curls=taking.open.curls), speed, least_s=0.4)
    before = replace(taking.before, position_m=taking.before.position_m + moved)
    hand.move(before, 0.5 * speed)
    hand.move(stage.rest(side), 0.6 * speed, [0.0, 0.0, 0.03])
    return stage.plan(
        hands,
        (Hold(can.name, side, taken, put_s),),
        (
            Cue("reach", begun, taken),
            Cue("to_mouth", taken, at_mouth),
            Cue("drink", at_mouth, leaving),
            Cue("put_back", leaving, put_s),
        ),
    )


FAMILIES: Mapping[str, Gesture] = {
    "drink": Gesture(
        ("hand", "speed", "wait", "hold", "tilt", "can_x", "can_y", "put_dx", "put_dy"),
        _drink_objects,
        _drink,
    ),
}
