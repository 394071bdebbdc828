"""Drinking from a can."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sim.families.at_mouth import held_at_mouth
from sim.families.sizes import CAN
from sim.families.using import use
from sim.motion.motion import Hold, MotionPlan
from sim.motion.planner import grasp
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.person.kinematics import OUTWARD
from sim.specs import ObjectSpec


def _drink_objects(values: Values) -> tuple[ObjectSpec, ...]:
    outward = OUTWARD[side_of(values, "hand")]
    place = (number(values, "can_x"), outward * number(values, "can_y"))
    return (ObjectSpec("can", "can", CAN, (0.72, 0.05, 0.05), place),)


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
    arriving = held_at_mouth(stage, side, taking.closed, can, place, 0.3)
    drinking = held_at_mouth(stage, side, taking.closed, can, place, stage.number("tilt"))
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
