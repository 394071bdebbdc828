"""Hand and head: one covers the other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.contact import height_above_table
from sim.families.on_head import Laying, laid_on_head
from sim.families.sizes import CAN
from sim.motion.curves import sweep
from sim.motion.motion import Cue, Hold, MotionPlan, object_at_rest, posture
from sim.motion.planner import HandPlanner, curled, grasp
from sim.motion.stage import STILL_S, Family, Stage, Values, no_objects, number, side_of
from sim.motion.strokes import HandState, between, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import SIDES, Transform
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


def _laid(stage: Stage, side: int, laying: Laying, swivel_rad: float) -> HandState:
    """One hand laid on the head while the other one rests."""
    like = replace(stage.rest(side), air=0.1, with_head=1.0, swivel_rad=swivel_rad)
    return laid_on_head(stage, side, laying, like, stage.rest(1 - side))


def _beside(touching: HandState, off_m: float, moved_m: Floats) -> HandState:
    """A hand on the head, about to come or just gone: off along its back and moved, (3,)."""
    away = touching.position_m + off_m * touching.rotation[:, 2] + moved_m
    swivel = 0.6 * touching.swivel_rad
    return replace(touching, position_m=away, with_head=0.5, air=0.6, swivel_rad=swivel)


# Where a hand touches the face, towards the hand's own side, and where its fingers then point.
_SPOTS: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "cheek": ((0.72, 0.62, -0.30), (-0.25, -0.35, 1.0)),
    "chin": ((0.86, 0.10, -0.66), (-0.1, -0.7, 0.7)),
    "mouth": ((0.95, 0.02, -0.58), (0.0, -1.0, 0.65)),
    "forehead": ((0.85, 0.10, 0.42), (0.0, -1.0, 0.75)),
}


def _touching(stage: Stage, side: int, place: str, jitter: Floats) -> HandState:
    """Fingers on a place of the face."""
    mirror = np.array([1.0, OUTWARD[side], 1.0])
    spot, fingers = (mirror * np.array(v) for v in _SPOTS[place])
    long, broad = stage.scene.anatomy.hand_length_m, stage.scene.anatomy.hand_breadth_m
    # The middle of the two middle fingers.
    pad = np.array([0.36 * long, 0.0, -0.10 * broad])
    laying = Laying(spot + jitter, fingers, pad, curled(0.2, thumb=0.15))
    return _laid(stage, side, laying, stage.number("elbow_out"))


def _touch_face(stage: Stage) -> MotionPlan:
    """A hand goes to the face, stays, comes back; some times over."""
    rng = stage.streams("touches")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    cues: list[Cue] = []
    wanted, which = str(stage.values["place"]), str(stage.values["hand"])
    order = [str(place) for place in rng.permutation(list(_SPOTS))]
    clock = STILL_S + stage.number("wait")
    for turn in range(round(stage.number("touches"))):
        chance = int(rng.integers(2))
        side = {"right": 0, "left": 1}.get(which, chance)
        place = order[turn % len(order)] if wanted == "any" else wanted
        speed = stage.number("speed") * float(rng.uniform(0.8, 1.0))
        stay = float(rng.uniform(stage.number("stay_least"), stage.number("stay_most")))
        jitter = rng.uniform(-0.06, 0.06, 3)
        hand = hands[side]
        hand.until(clock)
        begun = hand.clock_s
        on = _touching(stage, side, place, jitter)
        near = _beside(on, 0.05, np.array([0.02, 0.0, -0.03]))
        out = 0.12 * np.array([1.0, OUTWARD[side] * 0.6, 0.0])
        rest = stage.rest(side)
        half = replace(
            near, position_m=0.5 * (rest.position_m + near.position_m) + out, with_head=0.0, air=1.0
        )
        hand.add(sweep(hand.clock_s, (hand.state, half, near, on), speed))
        touched = hand.clock_s
        hand.wait(stay)
        left = hand.clock_s
        hand.add(sweep(left, (on, near, half, rest), 0.9 * speed))
        cues += [
            Cue(f"to_face:{SIDES[side]}", begun, touched),
            Cue(f"on_face:{place}", touched, left),
            Cue(f"from_face:{SIDES[side]}", left, hand.clock_s),
        ]
        clock = hand.clock_s + stage.number("wait") * float(rng.uniform(0.5, 1.5))
    return stage.plan(hands, cues=tuple(cues))


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
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand, rest = hands[side], stage.rest(side)
    phone = stage.scene.room.objects[0]
    lying = object_at_rest(stage.scene.room, phone.name).position_m
    flat = hand_rotation(side, _TAKING_RAD, 0.0, 0.0)
    open_, closed = curled(0.08, thumb=0.1), curled(0.3, thumb=0.35)
    thick = phone.size_m[2]
    off = np.array([0.02, 0.0, -height_above_table(anatomy, side, flat, open_) - 0.001])
    taken = HandState(
        lying + np.array([0.0, 0.0, thick]) - flat @ off, quaternion_of(flat), open_, air=0.0
    )
    above = replace(taken, position_m=taken.position_m + np.array([-0.03, 0.0, 0.04]), air=1.0)
    # The face of the phone that the hand does not hold lies at the cheek, its end at the ear.
    laying = Laying(
        np.array([0.22, outward, -0.28]),
        np.array([-0.6, 0.0, 0.8]),
        off - np.array([0.0, 0.0, thick]),
        closed,
        air_m=0.001,
        tilts_rad=(0.0, 0.12, 0.25),
    )
    at_ear = _laid(stage, side, laying, stage.number("elbow_out"))
    # The elbow swings out on the way, over the edge of the table.
    over = at_ear.swivel_rad + 0.3
    near = replace(_beside(at_ear, 0.05, np.array([0.04, 0.0, -0.02])), swivel_rad=over)
    half = replace(between(taken, near, 0.5), curls=closed, with_head=0.0, air=1.0, swivel_rad=over)
    half = replace(half, position_m=half.position_m + np.array([0.06, 0.04 * outward, 0.0]))
    hand.until(STILL_S + stage.number("wait"))
    begun = hand.clock_s
    hand.move(above, speed, [0.0, 0.0, 0.03])
    hand.move(taken, 0.5 * speed, least_s=0.4)
    taken_s = hand.clock_s
    hand.add(sweep(taken_s, (taken, half, near, at_ear), speed))
    at_ear_s = hand.clock_s
    hand.wait(stage.number("hold"))
    leaving = hand.clock_s
    moved = np.array([stage.number("put_dx"), outward * stage.number("put_dy"), 0.0])
    put = replace(taken, position_m=taken.position_m + moved)
    hand.add(sweep(leaving, (at_ear, near, half, put), 0.9 * speed))
    put_s = hand.clock_s
    hand.move(replace(above, position_m=above.position_m + moved), 0.6 * speed)
    hand.move(rest, 0.7 * speed, [0.0, 0.0, 0.03])
    return stage.plan(
        hands,
        (Hold(phone.name, side, taken_s, put_s),),
        (
            Cue("reach", begun, taken_s),
            Cue("to_ear", taken_s, at_ear_s),
            Cue("at_ear", at_ear_s, leaving),
            Cue("put_back", leaving, put_s),
        ),
    )


def _hand_behind_head(stage: Stage) -> MotionPlan:
    """A hand goes behind the head, stays hidden, comes out on its own or on the other side."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, swivel = OUTWARD[side], stage.number("elbow_out")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand, rest = hands[side], stage.rest(side)
    behind = _laid(
        stage,
        side,
        Laying(
            np.array([-1.0, -0.12 * outward, stage.number("height")]),
            np.array([0.0, -outward, 0.75]),
            np.array([0.03, 0.0, -0.02]),
            curled(0.22, thumb=0.3),
            tilts_rad=(0.1, 0.25, 0.0),
        ),
        swivel,
    )
    _, head = posture(stage.scene.anatomy, (stage.rest(0), stage.rest(1)), np.zeros(3))

    def free(ahead_m: float, out_m: float, up_m: float, like: float) -> HandState:
        """A hand in the air about the head's centre; its turn: 0 as it rests, 1 as behind."""
        turned = replace(between(rest, behind, like), with_head=0.0, air=1.0)
        place = head.position_m + np.array([ahead_m, out_m * outward, up_m])
        return replace(turned, position_m=place, curls=behind.curls)

    before = free(0.30, 0.19, -0.24, 0.15)
    beside = free(0.03, 0.27, 0.03, 0.7)
    # Round the corner of the head, not through it.
    off = np.array([-0.035, 0.085 * outward, 0.0])
    corner = replace(behind, position_m=behind.position_m + off, with_head=0.7, air=0.3)
    hand.until(STILL_S + stage.number("wait"))
    cues, clock = [], hand.clock_s
    for _ in range(round(stage.number("times"))):
        hand.until(clock)
        begun = hand.clock_s
        hand.add(sweep(begun, (rest, before, beside, corner, behind), speed))
        cues.append(Cue(f"behind_head:{SIDES[side]}", begun, hand.clock_s))
        hidden = hand.clock_s
        hand.wait(stage.number("hidden"))
        left = hand.clock_s
        if stage.values["out"] == "same":
            hand.add(sweep(left, (behind, corner, beside, before, rest), speed))
        else:
            _out_over_there(stage, side, hand, behind, (free(0.16, 0.22, 0.14, 0.5), before))
        cues += [Cue("behind", hidden, left), Cue("out", left, hand.clock_s)]
        clock = hand.clock_s + stage.number("wait")
    return stage.plan(hands, cues=tuple(cues))


def _out_over_there(
    stage: Stage,
    side: int,
    hand: HandPlanner,
    behind: HandState,
    back: tuple[HandState, HandState],
) -> None:
    """From behind the head to its other side, a look out, and back over the crown."""
    outward, swivel, speed = OUTWARD[side], stage.number("elbow_out"), stage.number("speed")
    peeking = _laid(
        stage,
        side,
        Laying(
            np.array([-0.55, -1.0 * outward, 0.2]),
            np.array([0.5, -0.6 * outward, 0.3]),
            np.array([0.03, 0.0, -0.02]),
            behind.curls,
            air_m=0.02,
            tilts_rad=(0.25, 0.4, 0.1),
        ),
        swivel,
    )
    on_crown = _laid(
        stage,
        side,
        Laying(
            np.array([-0.1, -0.1 * outward, 1.0]),
            np.array([0.0, -outward, 0.0]),
            np.array([0.03, 0.0, -0.02]),
            behind.curls,
            air_m=0.05,
        ),
        swivel,
    )
    hand.move(peeking, 0.5 * speed, [-0.02, 0.0, 0.0])
    hand.wait(stage.number("peek"))
    hand.add(sweep(hand.clock_s, (peeking, on_crown, *back, stage.rest(side)), speed))


FAMILIES: Mapping[str, Family] = {
    "drink": Family(
        ("hand", "speed", "wait", "hold", "tilt", "can_x", "can_y", "put_dx", "put_dy"),
        _drink_objects,
        _drink,
    ),
    "touch_face": Family(
        (
            "hand",
            "place",
            "touches",
            "speed",
            "stay_least",
            "stay_most",
            "wait",
            "elbow_out",
        ),
        no_objects,
        _touch_face,
    ),
    "phone_at_ear": Family(
        (
            "hand",
            "speed",
            "wait",
            "hold",
            "elbow_out",
            "phone_x",
            "phone_y",
            "put_dx",
            "put_dy",
        ),
        _phone_objects,
        _phone_at_ear,
    ),
    "hand_behind_head": Family(
        (
            "hand",
            "out",
            "speed",
            "hidden",
            "times",
            "peek",
            "height",
            "wait",
            "elbow_out",
        ),
        no_objects,
        _hand_behind_head,
    ),
}
