"""The families of motion: values of named parameters become a plan. A registry is a dict."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact import capsule_gap, hand_capsules
from sim.kinematics import OUTWARD, about_y, about_z, norm
from sim.motion import Cue, Hold, Plan, object_at_rest, posture
from sim.planner import HandPlanner, curled, grasp, raised, resting
from sim.pose import Transform
from sim.specs import ObjectSpec, SceneSpec
from sim.strokes import (
    Glide,
    HandState,
    Stroke,
    minimum_jerk,
    minimum_jerk_rate,
    minimum_jerk_second,
    quaternion_of,
    wobble,
)

Value = float | str
Values = Mapping[str, Value]
Streams = Callable[[str], np.random.Generator]  # name -> generator of that name

STILL_S = 1.1  # hands apart and still at the start: the thesis's first frames

CAN = (0.066, 0.066, 0.122)  # a 0.33 l can, extents x, y, z [m]
BOX = (0.055, 0.075, 0.075)


def _number(values: Values, name: str) -> float:
    return float(values[name])


def _side(values: Values, name: str) -> int:
    return {"right": 0, "left": 1}[str(values[name])]


@dataclass(frozen=True, eq=False)
class Stage:
    """What a family plans with: the scene, its values, its random streams, how long it plays."""

    scene: SceneSpec
    values: Values
    streams: Streams
    duration_s: float

    def number(self, name: str) -> float:
        """A numeric value in SI units."""
        return _number(self.values, name)

    def side(self, name: str) -> int:
        """0 for "right", 1 for "left"."""
        return _side(self.values, name)

    def rest(self, side: int, ahead_m: float = 0.0, outward_m: float = 0.0) -> HandState:
        """The hand at its place on the table, or shifted from it."""
        return resting(
            self.scene,
            side,
            self.number("rest_x") + ahead_m,
            self.number("rest_y") + outward_m,
            self.number("hand_inward"),
            self.number("hand_curl"),
        )

    def plan(
        self,
        hands: tuple[HandPlanner, HandPlanner],
        holds: tuple[Hold, ...] = (),
        cues: tuple[Cue, ...] = (),
    ) -> Plan:
        """The plan of these hands with this person's sway and tremor."""
        sway = wobble(self.streams("sway"), self.number("head_sway"), 0.2, 0.5)
        tremor = tuple(
            wobble(self.streams(f"tremor-{side}"), self.number("tremor"), 0.5, 1.6)
            for side in (0, 1)
        )
        return Plan(
            hands=(hands[0].path(), hands[1].path()),
            sway=sway,
            tremor=(tremor[0], tremor[1]),
            swivel_rad=self.number("elbow_swivel"),
            holds=holds,
            cues=cues,
        )


def _no_objects(values: Values) -> tuple[ObjectSpec, ...]:
    return ()


# --- calm_table: thesis Fig. 4.1-4.3 -------------------------------------------------------------


def _calm_objects(values: Values) -> tuple[ObjectSpec, ...]:
    x, y = _number(values, "object_x"), _number(values, "object_y")
    return (
        ObjectSpec("can", "can", CAN, (0.70, 0.06, 0.06), (x, -y)),
        ObjectSpec("box", "box", BOX, (0.12, 0.40, 0.16), (x - 0.02, y), yaw_rad=-0.45),
    )


def _calm_table(stage: Stage) -> Plan:
    """Reach, lift and slide by turns, and now and then carry the thing on that side."""
    rng = stage.streams("actions")
    top = stage.number("speed")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    room = stage.scene.room
    things = {0: room.objects[0], 1: room.objects[1]}
    places = {side: object_at_rest(room, thing.name) for side, thing in things.items()}
    holds: list[Hold] = []
    cues: list[Cue] = []
    clock, turn, side = STILL_S, 0, int(rng.integers(2))
    while clock < stage.duration_s:
        hand = hands[side]
        hand.until(clock)
        begun = hand.clock_s
        speed = top * float(rng.uniform(0.7, 1.0))
        kind = (
            "carry" if turn in (1, 2) or rng.random() < 0.2 else str(rng.choice(["reach", "slide"]))
        )
        # One draw each whatever the kind, so that a longer sequence begins like a shorter one.
        ahead, outward = float(rng.uniform(-0.02, 0.03)), float(rng.uniform(0.0, 0.08))
        lift, pause = float(rng.uniform(0.05, 0.13)), float(rng.uniform(0.3, 1.0))
        goal = stage.rest(side, ahead, outward)
        if kind == "carry":
            places[side], hold = _carry(
                stage, hand, side, things[side], places[side], top, (ahead, outward)
            )
            holds.append(hold)
            hand.move(goal, speed, [0.0, 0.0, 0.03])
        elif kind == "reach":
            up = raised(
                side,
                goal.position_m + np.array([0.02, 0.0, lift]),
                stage.number("hand_inward"),
                0.1,
                0.5,
                curl=0.25,
            )
            hand.move(up, top)
            hand.wait(pause)
            hand.move(goal, speed)
        else:
            hand.move(goal, top, [0.0, 0.0, 0.012])
        cues.append(Cue(f"{kind}:{('right', 'left')[side]}", begun, hand.clock_s))
        # The other hand often begins before this one is back.
        overlap = float(rng.choice([0.0, 0.0, 0.3])) * (hand.clock_s - begun)
        clock = hand.clock_s + pause - overlap
        turn += 1
        side = 1 - side if turn < 3 or rng.random() < 0.7 else side
    return stage.plan(hands, tuple(holds), tuple(cues))


def _carry(
    stage: Stage,
    hand: HandPlanner,
    side: int,
    thing: ObjectSpec,
    place: Transform,
    speed: float,
    shift: tuple[float, float],
) -> tuple[Transform, Hold]:
    """Take a thing, set it down a little further, let go: where it then stands, and the hold."""
    taking = grasp(stage.scene, side, thing, place)
    hand.move(taking.before, speed, [0.0, 0.0, 0.03])
    hand.move(taking.open, 0.7 * speed)
    hand.move(taking.closed, speed, least_s=0.45)
    taken_s = hand.clock_s
    home = object_at_rest(stage.scene.room, thing.name).position_m
    # Near its first place, so that it never wanders off.
    there = home + np.array([0.5 * shift[0], OUTWARD[side] * 0.4 * shift[1], 0.0])
    moved = there - place.position_m
    put = replace(taking.closed, position_m=taking.closed.position_m + moved)
    lifted = 0.5 * (taking.closed.position_m + put.position_m) + np.array([0.0, 0.0, 0.07])
    hand.move(replace(put, position_m=lifted, air=1.0), speed)
    hand.move(put, speed)
    put_s = hand.clock_s
    hand.move(replace(put, curls=taking.open.curls), speed, least_s=0.4)
    hand.move(replace(taking.before, position_m=taking.before.position_m + moved), 0.7 * speed)
    return (
        Transform(place.position_m + moved, place.rotation),
        Hold(thing.name, side, taken_s, put_s),
    )


# --- drink: thesis Fig. 4.4, 4.5 -----------------------------------------------------------------


def _drink_objects(values: Values) -> tuple[ObjectSpec, ...]:
    outward = OUTWARD[_side(values, "hand")]
    place = (_number(values, "can_x"), outward * _number(values, "can_y"))
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


# --- cross and bounce: one approach, two outcomes ------------------------------------------------


_RISE_M = 0.01  # of the farther hand over the nearer one: keeps it out of the other's forearm


@dataclass(frozen=True, eq=False)
class _Approach:
    """Both hands up, apart, one nearer to the cameras, about to stroke through the middle."""

    hands: tuple[HandPlanner, HandPlanner]
    apart: tuple[HandState, HandState]
    crossed: tuple[HandState, HandState]
    bows_m: tuple[Floats, Floats]


def _approach(stage: Stage) -> _Approach:
    front = stage.side("front")
    gap, height, x = stage.number("depth_gap"), stage.number("height"), stage.number("centre_x")
    spread, past, bow = stage.number("spread"), stage.number("past"), stage.number("bow")
    apart, crossed, bows = [], [], []
    for side in (0, 1):
        ahead = 0.5 if side == front else -0.5
        # The farther hand passes higher: below it, the nearer arm comes in from its elbow.
        away = np.array([ahead * gap, 0.0, -ahead * _RISE_M])
        centre = np.array([x, 0.0, stage.scene.room.table_height_m + height]) + away
        lateral = np.array([0.0, OUTWARD[side], 0.0])
        held = raised(side, centre, 1.0, -0.35, 1.2, curl=0.16)
        apart.append(replace(held, position_m=centre + spread * lateral))
        crossed.append(replace(held, position_m=centre - past * lateral))
        bows.append(np.array([2.0 * ahead * bow, 0.0, 0.0]))
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    start = STILL_S + stage.number("wait")
    for side in (0, 1):
        hands[side].until(start)
        hands[side].move(apart[side], stage.number("raise_speed"), [0.0, 0.0, 0.02])
    ready = max(hand.clock_s for hand in hands) + 0.4
    for hand in hands:
        hand.until(ready)
    return _Approach(hands, (apart[0], apart[1]), (crossed[0], crossed[1]), (bows[0], bows[1]))


def _meeting_share(stage: Stage) -> float:
    """Share u of the crossing stroke's way after which the palms are merge_gap apart across."""
    spread, past = stage.number("spread"), stage.number("past")
    return (spread - 0.5 * stage.number("merge_gap")) / (spread + past)


def _share_time(u: float) -> float:
    """The share s of the time with minimum_jerk(s) = u, by bisection to 1e-15."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if minimum_jerk(middle) < u else (low, middle)
    return 0.5 * (low + high)


def _lower(stage: Stage, hands: tuple[HandPlanner, HandPlanner]) -> None:
    """Both hands back to their places on the table."""
    for side in (0, 1):
        hands[side].move(stage.rest(side), stage.number("raise_speed"), [0.0, 0.0, 0.02])


def _cross(stage: Stage) -> Plan:
    """The hands pass each other, stay crossed, and go back if the parameter `back` says so."""
    a = _approach(stage)
    speed = stage.number("speed")
    strokes = [a.hands[s].move(a.crossed[s], speed, a.bows_m[s]) for s in (0, 1)]
    cues = [_merge_cue(stage, strokes[0], "cross")]
    crossed_s = strokes[0].end_s
    for hand in a.hands:
        hand.wait(stage.number("hold"))
    held_s = a.hands[0].clock_s
    cues.append(Cue("crossed", crossed_s, held_s))
    if stage.values["back"] == "yes":
        strokes = [a.hands[s].move(a.apart[s], speed, a.bows_m[s]) for s in (0, 1)]
        cues.append(Cue("cross_back", strokes[0].start_s, strokes[0].end_s))
        for hand in a.hands:
            hand.wait(0.4)
        _lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


def _merge_cue(stage: Stage, stroke: Stroke, name: str) -> Cue:
    """The time of the stroke in which the palms are less than merge_gap apart across."""
    spread, past = stage.number("spread"), stage.number("past")
    entry = _meeting_share(stage)
    leave = min((spread + 0.5 * stage.number("merge_gap")) / (spread + past), 1.0)
    first, last = (stroke.start_s + stroke.duration_s * _share_time(u) for u in (entry, leave))
    return Cue(name, first, last)


def _touching(stage: Stage, a: _Approach) -> tuple[Floats, Floats]:
    """Palms (right, left), each (3,) [m], where the hands just touch: laid over each other.

    They are touch_gap apart across; along the depth, as little as leaves them out of each other.
    """
    centre = 0.5 * (a.crossed[0].position_m + a.crossed[1].position_m)
    across = 0.5 * stage.number("touch_gap")
    depth = a.apart[0].position_m - a.apart[1].position_m
    depth = np.array([depth[0], 0.0, depth[2]]) / math.hypot(depth[0], depth[2])

    def places(gap_m: float) -> tuple[Floats, Floats]:
        right = centre + 0.5 * gap_m * depth + np.array([0.0, OUTWARD[0] * across, 0.0])
        left = centre - 0.5 * gap_m * depth + np.array([0.0, OUTWARD[1] * across, 0.0])
        return right, left

    shapes = [hand_capsules(stage.scene.anatomy, s, a.apart[s].curls) for s in (0, 1)]
    low, high = 0.0, 0.25
    for _ in range(20):
        middle = 0.5 * (low + high)
        bars = [shapes[s].placed(places(middle)[s], a.apart[s].rotation) for s in (0, 1)]
        low, high = (low, middle) if capsule_gap(bars[0], bars[1])[0] <= 0.0 else (middle, high)
    return places(high)


def _bounce(stage: Stage) -> Plan:
    """The same approach, but where the hands would merge they brake, touch and return."""
    a = _approach(stage)
    speed = stage.number("speed")
    meeting = _meeting_share(stage)
    s = _share_time(meeting)
    touching = _touching(stage, a)
    for side in (0, 1):
        hand = a.hands[side]
        start, goal, bow = a.apart[side].position_m, a.crossed[side].position_m, a.bows_m[side]
        stroke = hand.move(a.crossed[side], speed, bow)
        T, u = stroke.duration_s, meeting
        rate, second = minimum_jerk_rate(s) / T, minimum_jerk_second(s) / (T * T)
        along = goal - start + 4.0 * (1.0 - 2.0 * u) * bow
        velocity = rate * along
        acceleration = second * along - 8.0 * rate * rate * bow
        broken_s = stroke.start_s + s * T
        touch_m = touching[side]
        touch = replace(a.apart[side], position_m=touch_m)
        # Twice the way over the speed: a brake that neither overshoots nor creeps.
        way = norm(touch_m - stroke.at(broken_s, a.apart[side]).position_m)
        brake = Glide(
            start_s=broken_s,
            duration_s=max(2.0 * way / norm(velocity), 0.15),
            to=touch,
            velocity_mps=velocity,
            acceleration_mps2=acceleration,
            begun=a.apart[side],
            begun_share=u,
            begun_rate=rate,
        )
        hand.moves.append(brake)
        hand.clock_s = brake.end_s
    ended = max(hand.clock_s for hand in a.hands)
    cues = [Cue("bounce", a.hands[0].moves[-1].start_s, ended)]
    for side in (0, 1):
        hand = a.hands[side]
        hand.until(ended + stage.number("touch"))
        hand.move(a.apart[side], speed)
    touched = a.hands[0].moves[-1].start_s
    cues.append(Cue("touch", ended, touched))
    cues.append(Cue("return", touched, a.hands[0].clock_s))
    for hand in a.hands:
        hand.wait(stage.number("hold"))
    _lower(stage, a.hands)
    return stage.plan(a.hands, cues=tuple(cues))


# --- speed_ladder: the headline curve ------------------------------------------------------------

RUNGS = 9


def _speed_ladder(stage: Stage) -> Plan:
    """One hand to and fro along a line, rung after rung faster; the other hand rests."""
    side = stage.side("hand")
    outward, rng = OUTWARD[side], stage.streams("ladder")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand = hands[side]
    length, aside = stage.number("length"), stage.number("turn")
    centre = np.array(
        [
            stage.number("centre_x"),
            outward * stage.number("centre_y"),
            stage.scene.room.table_height_m + stage.number("height"),
        ]
    )
    along = 0.5 * length * np.array([math.sin(aside), -outward * math.cos(aside), 0.0])
    ends = [raised(side, centre + k * along, 0.35, 0.0, 0.6, curl=0.2) for k in (-1.0, 1.0)]
    hand.until(STILL_S)
    hand.move(ends[0], 0.3, [0.0, 0.0, 0.02])
    cues = []
    for rung in range(1, RUNGS + 1):
        speed = stage.number(f"rung_{rung}")
        hand.wait(stage.number("pause"))
        begun = hand.clock_s
        # To and fro at least once, and for 2.5 s or more, so that a rung has frames to score.
        times = max(1, math.ceil(2.5 / (2 * 1.875 * length / speed)))
        for _ in range(times):
            for end in (ends[1], ends[0]):
                hand.move(end, speed, least_s=0.01)
                # An uneven turn keeps fast rungs from falling in step with the frames.
                hand.wait(float(rng.uniform(0.0, 0.08)))
        cues.append(Cue(f"speed:{speed:g}", begun, hand.clock_s))
    hand.wait(stage.number("pause"))
    hand.move(stage.rest(side), 0.3, [0.0, 0.0, 0.02])
    return stage.plan(hands, cues=tuple(cues))


# --- registry ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Gesture:
    """A family's entry: the parameters it needs, the objects it puts on the table, its plan."""

    parameters: tuple[str, ...]
    objects: Callable[[Values], tuple[ObjectSpec, ...]]
    plan: Callable[[Stage], Plan]


_APPROACH = (
    "speed",
    "raise_speed",
    "depth_gap",
    "front",
    "height",
    "centre_x",
    "spread",
    "past",
    "bow",
    "merge_gap",
    "wait",
    "hold",
)

GESTURES: Mapping[str, Gesture] = {
    "calm_table": Gesture(("speed", "object_x", "object_y"), _calm_objects, _calm_table),
    "drink": Gesture(
        ("hand", "speed", "wait", "hold", "tilt", "can_x", "can_y", "put_dx", "put_dy"),
        _drink_objects,
        _drink,
    ),
    "cross": Gesture((*_APPROACH, "back"), _no_objects, _cross),
    "bounce": Gesture((*_APPROACH, "touch_gap", "touch"), _no_objects, _bounce),
    "speed_ladder": Gesture(
        (
            "hand",
            "length",
            "turn",
            "height",
            "centre_x",
            "centre_y",
            "pause",
            *(f"rung_{k}" for k in range(1, RUNGS + 1)),
        ),
        _no_objects,
        _speed_ladder,
    ),
}

__all__ = ["GESTURES", "Gesture", "Stage", "Value", "Values", "curled"]
