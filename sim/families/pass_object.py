"""An object passed from hand to hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.contact.capsules import Capsules
from sim.families.touching import brought, closed, hand_bars, object_bars
from sim.motion.motion import Hold, MotionPlan, successive
from sim.motion.planner import RISING_M, curled, grasp, meet
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import SIDES, Transform
from sim.specs import RGB, ObjectSpec
from sim.vectors import about_z

_OBJECTS: Mapping[str, tuple[str, tuple[float, float, float], RGB, float]] = {
    # kind, extents, colour, yaw: the cup's handle points to the person, between the hands
    "cup": ("cup", (0.100, 0.100, 0.100), (0.20, 0.55, 0.30), 0.5 * math.pi),
    "box": ("box", (0.075, 0.095, 0.100), (0.62, 0.12, 0.40), 0.0),
    "ball": ("ball", (0.110, 0.110, 0.110), (0.15, 0.45, 0.70), 0.0),
}


def _passed_objects(values: Values) -> tuple[ObjectSpec, ...]:
    kind, size, rgb, yaw = _OBJECTS[str(values["thing"])]
    outward = OUTWARD[side_of(values, "giver")]
    place = (number(values, "thing_x"), outward * number(values, "thing_y"))
    return (ObjectSpec("thing", kind, size, rgb, place, yaw),)


def _pass_object(stage: Stage) -> MotionPlan:
    """A hand brings an object to the middle; the other takes it there and sets it down."""
    giver, speed = stage.side("giver"), stage.number("speed")
    taker, anatomy = 1 - giver, stage.scene.anatomy
    hands = stage.planners(stage.start_s)
    passed, place = stage.object_named("thing")
    taking = grasp(stage.scene, giver, passed, place)
    most = curled(0.7, thumb=0.7)
    gripped = closed(anatomy, giver, taking.open, most, object_bars(passed, place))
    begun = hands[giver].clock_s
    taken = hands[giver].take(replace(taking, closed=gripped), speed)
    # Up and to the middle; the hand turns so that its palm faces the other's.
    middle = Transform(stage.centre_m, about_z(_turn_of(giver)) @ place.rotation)
    giving = _carried(gripped, place, middle)
    hands[giver].move(giving, speed, [0.02, 0.0, 0.03])
    arrived = hands[giver].clock_s
    mirror = np.array([1.0, -1.0, 1.0])
    rotation = hand_rotation(taker, 0.45 - abs(_turn_of(giver)), 0.0, 1.45)
    facing = HandState(
        middle.position_m + mirror * (giving.position_m - middle.position_m),
        quaternion_of(rotation),
        taking.open.curls,
    )
    around = _together(object_bars(passed, middle), hand_bars(anatomy, giver, giving))
    inward = np.array([0.0, -OUTWARD[taker], 0.0])
    open_ = brought(anatomy, taker, facing, inward, around)
    held = closed(anatomy, taker, open_, most, around)
    before = replace(open_.moved(-0.09 * inward - [0.05, 0.0, 0.0]), air=1.0)
    hands[taker].until(max(taken, arrived - 0.8))
    hands[taker].move(before, speed, RISING_M)
    meet(hands)
    hands[taker].move(open_, 0.6 * speed)
    hands[taker].move(held, speed, least_s=0.4)
    both = meet(hands)
    over = meet(hands, stage.number("both_hold"))
    away = np.array([-0.05, 0.09 * OUTWARD[giver], 0.0])
    hands[giver].move(replace(giving, curls=taking.open.curls), speed, least_s=0.35)
    hands[giver].move(replace(giving.moved(away), curls=taking.open.curls, air=1.0), 0.7 * speed)
    released = hands[giver].clock_s
    hands[giver].move(stage.rest(giver), speed, RISING_M)
    # The taker goes on when the other hand has let go.
    hands[taker].until(released)
    y = OUTWARD[taker] * stage.number("put_y")
    down_m = np.array([stage.number("put_x"), y, place.position_m[2]])
    down = Transform(down_m, about_z(-_turn_of(taker)) @ middle.rotation)
    put = _carried(held, middle, down)
    hands[taker].move(replace(put, air=0.0), speed, [0.02, 0.0, 0.03])
    put_s = hands[taker].clock_s
    hands[taker].move(replace(put, curls=taking.open.curls, air=0.0), speed, least_s=0.4)
    back = -0.06 * put.rotation[:, 0] + 0.035 * put.rotation[:, 2] + np.array([0.0, 0.0, 0.01])
    hands[taker].move(replace(put.moved(back), curls=taking.open.curls, air=1.0), 0.5 * speed)
    hands[taker].move(stage.rest(taker), speed, [0.0, 0.0, 0.03])
    return stage.plan(
        hands,
        holds=(
            Hold("thing", giver, taken, over, put_down=False),
            Hold("thing", taker, over, put_s),
        ),
        cues=successive(
            begun,
            ("reach", taken),
            (f"held_by:{SIDES[giver]}", both),
            ("held_by:both", over),
            (f"held_by:{SIDES[taker]}", put_s),
        ),
    )


def _turn_of(side: int) -> float:
    """Angle [rad] by which a hand turns the object about the vertical on its way to the middle."""
    return OUTWARD[side] * 0.35


def _carried(hand: HandState, begun: Transform, to: Transform) -> HandState:
    """The state of a hand that holds an object after it went from `begun` to `to`, both upright."""
    turn = to.rotation @ begun.rotation.T
    return replace(
        hand,
        position_m=to.position_m + turn @ (hand.position_m - begun.position_m),
        quaternion=quaternion_of(turn @ hand.rotation),
    )


def _together(a: Capsules, b: Capsules) -> Capsules:
    return Capsules(
        np.concatenate([a.starts_m, b.starts_m]),
        np.concatenate([a.ends_m, b.ends_m]),
        np.concatenate([a.radii_m, b.radii_m]),
    )


FAMILIES: Mapping[str, Family] = {
    "pass_object": Family(
        (
            "giver",
            "thing",
            "both_hold",
            "speed",
            "thing_x",
            "thing_y",
            "put_x",
            "put_y",
            "height",
            "centre_x",
            "wait",
        ),
        _pass_object,
        _passed_objects,
    ),
}
