"""Skin that belongs to no target: a block of its colour, bare forearms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.motion.motion import Cue, Hold, MotionPlan
from sim.motion.planner import grasp, raised
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.person.kinematics import OUTWARD
from sim.pose import SIDES
from sim.specs import ObjectSpec


def _wood_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """A block of wood near the colour of skin."""
    tone = number(values, "tone")
    red, green, blue = 0.80 * tone, 0.58 * tone, 0.43 * tone
    outward = OUTWARD[side_of(values, "hand")]
    place = (number(values, "block_x"), outward * number(values, "block_y"))
    size = (0.055, 0.07, number(values, "tall"))
    return (ObjectSpec("block", "block", size, (red, green, blue), place, yaw_rad=0.2 * outward),)


def _skin_coloured_object(stage: Stage) -> MotionPlan:
    """A hand takes the block, shows it before the chest, sets it down further out, and rests."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward = OUTWARD[side]
    taking = grasp(stage.scene, side, *stage.object_named("block"))
    hands = stage.planners(stage.start_s)
    hand = hands[side]
    taken = hand.take(taking, speed)
    rng = stage.streams("shows")
    for _ in range(round(stage.number("shows"))):
        shift = np.array([-0.04, outward * 0.1, 0.1]) + rng.uniform(
            [-0.03, -0.06, 0.0], [0.03, 0.06, 0.14]
        )
        shown = replace(taking.closed.moved(shift), air=1.0)
        hand.move(shown, speed, [0.0, 0.0, 0.02])
        hand.wait(stage.number("pause"))
    moved = np.array([0.0, outward * stage.number("put_dy"), 0.0])
    put = taking.closed.moved(moved)
    hand.move(put, speed)
    put_s = hand.clock_s
    hand.let_go(taking, put, moved, speed, 0.5 * speed)
    hand.move(stage.rest(side), speed, [0.0, 0.0, 0.03])
    return stage.plan(hands, (Hold("block", side, taken, put_s),), (Cue("carried", taken, put_s),))


def _bare_forearm(stage: Stage) -> MotionPlan:
    """Talking hands: forearms stood up, laid forward, spread; they are skin, but no target."""
    hands = stage.planners()
    top = stage.scene.room.table_height_m
    cues = []
    for side in (0, 1):
        hand, rng = hands[side], stage.streams(f"gestures-{side}")
        hand.until(stage.start_s + 0.8 * rng.random())
        while hand.clock_s < stage.duration_s:
            # The same draws whatever the kind: a longer sequence begins like a shorter sequence.
            kind = str(rng.choice(["stand", "forward", "spread"], p=[0.5, 0.25, 0.25]))
            ahead, out, up = rng.random(3).tolist()
            speed = stage.number("speed") * rng.uniform(0.6, 1.0)
            pause = stage.number("pause") * rng.uniform(0.5, 1.5)
            outward = OUTWARD[side]
            if kind == "stand":
                place = [0.22 + 0.06 * ahead, outward * (0.2 + 0.08 * out), top + 0.24 + 0.1 * up]
                to = raised(side, place, 0.2, -1.0, 0.9, curl=0.2)
            elif kind == "forward":
                place = [0.38 + 0.06 * ahead, outward * (0.14 + 0.1 * out), top + 0.1 + 0.05 * up]
                to = raised(side, place, 0.3, 0.0, 0.7, curl=0.2)
            else:
                place = [0.28 + 0.06 * ahead, outward * (0.34 + 0.1 * out), top + 0.16 + 0.1 * up]
                to = raised(side, place, -0.2, -0.4, 0.9, curl=0.15)
            begun = hand.clock_s
            hand.move(to, speed, [0.0, outward * 0.02, 0.02])
            hand.wait(pause)
            cues.append(Cue(f"{kind}:{SIDES[side]}", begun, hand.clock_s))
    return stage.plan(hands, cues=tuple(cues))


FAMILIES: Mapping[str, Family] = {
    "skin_coloured_object": Family(
        (
            "hand",
            "tone",
            "tall",
            "block_x",
            "block_y",
            "put_dy",
            "shows",
            "pause",
            "speed",
            "wait",
        ),
        _skin_coloured_object,
        _wood_objects,
    ),
    "bare_forearm": Family(("speed", "pause", "wait"), _bare_forearm),
}
