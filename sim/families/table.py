"""Calm work at a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.things import BOX, CAN
from sim.kinematics import OUTWARD
from sim.motion import Cue, Hold, Plan, object_at_rest
from sim.planner import HandPlanner, grasp, raised
from sim.pose import Transform
from sim.specs import ObjectSpec
from sim.stage import STILL_S, Gesture, Stage, Values, number


def _calm_objects(values: Values) -> tuple[ObjectSpec, ...]:
    x, y = number(values, "object_x"), number(values, "object_y")
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


FAMILIES: Mapping[str, Gesture] = {
    "calm_table": Gesture(("speed", "object_x", "object_y"), _calm_objects, _calm_table),
}
