"""A phone held at the ear."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.contact.arm_shape import height_above_table
from sim.families.on_head import Laying, beside, laid_alone
from sim.families.using import use
from sim.motion.curves import sweep
from sim.motion.motion import Hold, MotionPlan
from sim.motion.planner import curled
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.motion.strokes import HandState, between, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.specs import ObjectSpec

_PHONE = (0.072, 0.148, 0.009)

_TAKING_RAD = 0.5  # the hand over the phone, fingers turned inwards

_ACROSS_RAD = 0.45  # between the fingers and the phone's length


def _phone_objects(values: Values) -> tuple[ObjectSpec, ...]:
    outward = OUTWARD[side_of(values, "hand")]
    place = (number(values, "phone_x"), outward * number(values, "phone_y"))
    yaw = outward * (_ACROSS_RAD - _TAKING_RAD) - 0.5 * math.pi
    return (ObjectSpec("phone", "phone", _PHONE, (0.06, 0.06, 0.07), place, yaw),)


def _phone_at_ear(stage: Stage) -> MotionPlan:
    """Take the phone, hold it at the ear, put it back."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, anatomy = OUTWARD[side], stage.scene.anatomy
    hands = stage.planners(stage.start_s)
    hand, rest = hands[side], stage.rest(side)
    phone, place = stage.object_named("phone")
    lying = place.position_m
    flat = hand_rotation(side, _TAKING_RAD, 0.0, 0.0)
    open_, closed = curled(0.08, thumb=0.1), curled(0.3, thumb=0.35)
    thick = phone.size_m[2]
    off = np.array([0.02, 0.0, -height_above_table(anatomy, side, flat, open_) - 0.001])
    taken = HandState(
        lying + np.array([0.0, 0.0, thick]) - flat @ off, quaternion_of(flat), open_, air=0.0
    )
    above = replace(taken.moved([-0.03, 0.0, 0.04]), air=1.0)
    # The face of the phone that the hand does not hold lies at the cheek, its end at the ear.
    laying = Laying(
        np.array([0.22, outward, -0.28]),
        np.array([-0.6, 0.0, 0.8]),
        off - np.array([0.0, 0.0, thick]),
        closed,
        air_m=0.001,
        tilts_rad=(0.0, 0.12, 0.25),
    )
    at_ear = laid_alone(stage, side, laying, stage.number("elbow_out"))
    # The elbow swings out on the way, over the edge of the table.
    over = at_ear.swivel_rad + 0.3
    near = replace(beside(at_ear, 0.05, np.array([0.04, 0.0, -0.02])), swivel_rad=over)
    half = replace(between(taken, near, 0.5), curls=closed, with_head=0.0, air=1.0, swivel_rad=over)
    half = half.moved([0.06, 0.04 * outward, 0.0])
    begun = hand.clock_s
    hand.move(above, speed, [0.0, 0.0, 0.03])
    hand.move(taken, 0.5 * speed, least_s=0.4)
    taken_s = hand.clock_s
    hand.add(sweep(taken_s, (taken, half, near, at_ear), speed))
    at_ear_s = hand.clock_s
    hand.wait(stage.number("hold"))
    leaving = hand.clock_s
    moved = np.array([stage.number("put_dx"), outward * stage.number("put_dy"), 0.0])
    put = taken.moved(moved)
    hand.add(sweep(leaving, (at_ear, near, half, put), 0.9 * speed))
    put_s = hand.clock_s
    hand.move(above.moved(moved), 0.6 * speed)
    hand.move(rest, 0.7 * speed, [0.0, 0.0, 0.03])
    hold = Hold(phone.name, side, taken_s, put_s)
    return stage.plan(hands, (hold,), use(hold, begun, ("to_ear", at_ear_s), ("at_ear", leaving)))


FAMILIES: Mapping[str, Family] = {
    "phone_at_ear": Family(
        ("hand", "speed", "wait", "hold", "elbow_out", "phone_x", "phone_y", "put_dx", "put_dy"),
        _phone_at_ear,
        _phone_objects,
    ),
}
