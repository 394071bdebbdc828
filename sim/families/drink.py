"""Drinking from a can."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.sizes import CAN
from sim.families.using import use
from sim.motion.motion import Hold, MotionPlan
from sim.motion.planner import grasp
from sim.motion.posture import posture
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD
from sim.pose import Transform
from sim.specs import ObjectSpec
from sim.vectors import about_y, about_z


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


def _drink(stage: Stage) -> MotionPlan:
    """Reach for the can, drink, put it back, and rest."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward = OUTWARD[side]
    hands = stage.planners(stage.start_s)
    hand = hands[side]
    can, place = stage.object_named("can")
    taking = grasp(stage.scene, side, can, place)
    begun = hand.clock_s
    taken = hand.take(taking, speed)
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
    put = taking.closed.moved(moved)
    hand.move(put, 0.85 * speed, away)
    put_s = hand.clock_s
    hand.let_go(taking, put, moved, speed, 0.5 * speed)
    hand.move(stage.rest(side), 0.6 * speed, [0.0, 0.0, 0.03])
    hold = Hold(can.name, side, taken, put_s)
    return stage.plan(hands, (hold,), use(hold, begun, ("to_mouth", at_mouth), ("drink", leaving)))


FAMILIES: Mapping[str, Family] = {
    "drink": Family(
        ("hand", "speed", "wait", "hold", "tilt", "can_x", "can_y", "put_dx", "put_dy"),
        _drink,
        _drink_objects,
    ),
}
