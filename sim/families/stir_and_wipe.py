"""Stirring in a cup and wiping with a cloth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.contact.arm_shape import height_above_table
from sim.motion.curves import Curve, ellipse, figure_eight, rounds
from sim.motion.motion import Cue, Hold, MotionPlan
from sim.motion.planner import HandPlanner, curled, grasp
from sim.motion.stage import Family, Stage, Values, number, side_of
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.specs import ObjectSpec

_ROD = (0.23, 0.011, 0.011)

_CLOTH = (0.18, 0.16, 0.006)

_CUP_HEIGHT_M = 0.105


def _stir_objects(values: Values) -> tuple[ObjectSpec, ...]:
    outward = OUTWARD[side_of(values, "hand")]
    x, y = number(values, "place_x"), number(values, "place_y")
    stirs = values["task"] == "stir"
    # Wide enough for the round inside its walls.
    wide = (number(values, "stir_size") + 0.036) / 0.74
    # The handle, at the cup's +y, points to the cameras.
    cup_at = (x, outward * y) if stirs else (x + 0.10, -outward * 0.06)
    cup = ObjectSpec(
        "cup", "cup", (wide, wide, _CUP_HEIGHT_M), (0.78, 0.78, 0.74), cup_at, -0.5 * math.pi
    )
    if stirs:
        lying = (x + 0.05, outward * (y + 0.235))
        turned = -outward * number(values, "hand_inward") + 0.5 * math.pi
        return (cup, ObjectSpec("rod", "rod", _ROD, (0.55, 0.56, 0.58), lying, turned))
    spread = (x + 0.01, outward * (y + 0.15))
    return (cup, ObjectSpec("cloth", "sheet", _CLOTH, (0.20, 0.38, 0.52), spread))


def _round(stage: Stage, size_m: float, rng: np.random.Generator) -> Curve:
    """A closed, level curve about the origin, size_m wide: the shape that the parameters name."""
    a, turn = float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.choice([-1.0, 1.0]))
    first = 0.5 * size_m * np.array([math.cos(a), math.sin(a), 0.0])
    second = 0.5 * size_m * turn * np.array([-math.sin(a), math.cos(a), 0.0])
    shape = stage.values["shape"]
    if shape == "eight":
        return figure_eight(first, 0.45 * second, np.zeros(3))
    return ellipse(first, second if shape == "circle" else 0.55 * second, np.zeros(3))


def _bouts(stage: Stage, hand: HandPlanner, centre: HandState, size_m: float) -> list[Cue]:
    """Add bouts of rounds about a state, with stillness between; returns their cues."""
    task, cues = str(stage.values["task"]), []
    rng = stage.streams("rounds")
    for _ in range(round(stage.number("bouts"))):
        curve = _round(stage, size_m, rng)
        begins = centre.moved(curve.at(0.0))
        hand.move(begins, 0.15)
        hertz = stage.number("rounds") * float(rng.uniform(0.93, 1.07))
        hertz = min(max(hertz, 0.3), 1.4)
        bout = rounds(hand.clock_s, begins, curve, hertz, stage.number("bout"), 0.7)
        hand.add(bout)
        cues.append(Cue(task, bout.start_s, bout.end_s))
        hand.wait(stage.number("pause") * float(rng.uniform(0.6, 1.4)))
    return cues


def _stir_and_wipe(stage: Stage) -> MotionPlan:
    """A hand stirs in the cup or wipes with a cloth; the other holds the cup or rests."""
    side = stage.side("hand")
    hands = stage.planners(stage.start_s)
    other = hands[1 - side]
    holds: list[Hold] = []
    if stage.values["other"] == "holds_cup":
        other.take(grasp(stage.scene, 1 - side, *stage.object_named("cup")), stage.number("speed"))
    held_s = other.clock_s
    act = _stir if stage.values["task"] == "stir" else _wipe
    hold, cues = act(stage, side, hands[side])
    holds.append(hold)
    hands[side].move(stage.rest(side), stage.number("speed"), [0.0, 0.0, 0.04])
    if other.moves:
        other.until(hands[side].clock_s - 1.0)
        holds.append(Hold("cup", 1 - side, held_s, other.clock_s))
        cues.append(Cue("hold_cup", held_s, other.clock_s))
        other.move(replace(other.state, curls=curled(0.12, thumb=0.05)), 0.3, least_s=0.4)
        away = np.array([-0.05, OUTWARD[1 - side] * 0.05, 0.02])
        other.move(other.state.moved(away), 0.2)
        other.move(stage.rest(1 - side), stage.number("speed"), [0.0, 0.0, 0.03])
    return stage.plan(hands, tuple(holds), tuple(cues))


def _stir(stage: Stage, side: int, hand: HandPlanner) -> tuple[Hold, list[Cue]]:
    """Take the rod from the table, stir, lay it back: the hold of the rod, and the cues."""
    speed = stage.number("speed")
    (cup, cup_place), (rod, lying) = stage.object_named("cup"), stage.object_named("rod")
    thumb = -OUTWARD[side]  # along the hand's y
    length, radius = rod.size_m[0], 0.5 * rod.size_m[1]
    flat = hand_rotation(side, stage.number("hand_inward"), 0.0, 0.0)
    # Under the palm, the longer end out at the little finger.
    below = 0.19 * stage.scene.anatomy.hand_breadth_m + radius + 0.003
    rod_in_hand = np.array([0.028, -thumb * (0.5 * length - 0.045), -below])
    on_rod = lying.position_m + np.array([0.0, 0.0, radius]) - flat @ rod_in_hand
    taken = HandState(on_rod, quaternion_of(flat), curled(0.08, thumb=0.1))
    above = replace(taken, position_m=on_rod + np.array([-0.02, 0.0, 0.05]), air=1.0)
    begun = hand.clock_s
    hand.move(above, speed, [0.0, 0.0, 0.03])
    hand.move(taken, 0.5 * speed, least_s=0.4)
    from_s = hand.clock_s
    upright = hand_rotation(side, 0.55, 0.0, 1.5)
    lower_end = rod_in_hand - np.array([0.0, thumb * (0.5 * length - radius), 0.0])
    bottom = cup_place.position_m + np.array([0.0, 0.0, 0.1 * cup.size_m[2] + 0.008])
    stirring = HandState(
        bottom - upright @ lower_end, quaternion_of(upright), curled(0.72, thumb=0.6), air=0.3
    )
    over = replace(stirring.moved([0.0, 0.0, cup.size_m[2] + 0.02]), air=1.0)
    lifted = replace(over, position_m=0.5 * (over.position_m + on_rod) + [0.0, 0.0, 0.10])
    half_up = hand_rotation(side, 0.5, 0.0, 0.9)
    lifted = replace(lifted, quaternion=quaternion_of(half_up))
    hand.move(lifted, speed)
    hand.move(over, speed)
    hand.move(stirring, 0.5 * speed)
    cues = [Cue("take", begun, hand.clock_s)]
    cues += _bouts(stage, hand, stirring, stage.number("stir_size"))
    leaving = hand.clock_s
    hand.move(over, 0.5 * speed)
    hand.move(lifted, speed)
    hand.move(taken, speed, least_s=0.8)
    to_s = hand.clock_s
    hand.move(above, 0.5 * speed)
    cues.append(Cue("put_back", leaving, to_s))
    return Hold("rod", side, from_s, to_s), cues


def _wipe(stage: Stage, side: int, hand: HandPlanner) -> tuple[Hold, list[Cue]]:
    """Lay the hand on the cloth, wipe, leave it: the hold of the cloth, and the cues."""
    speed = stage.number("speed")
    cloth, place = stage.object_named("cloth")
    flat = hand_rotation(side, stage.number("hand_inward"), 0.0, 0.0)
    curls = curled(0.05, thumb=0.05)
    lies = height_above_table(stage.scene.anatomy, side, flat, curls) + cloth.size_m[2] + 1e-3
    # The palm a little behind the cloth's middle: the fingers lie on it too.
    on_cloth = HandState(
        place.position_m + np.array([-0.015, 0.0, lies]), quaternion_of(flat), curls
    )
    begun = hand.clock_s
    hand.move(on_cloth, speed, [0.0, 0.0, 0.05])
    from_s = hand.clock_s
    cues = [Cue("take", begun, from_s)]
    cues += _bouts(stage, hand, on_cloth, stage.number("wipe_size"))
    hand.move(on_cloth, 0.2)
    return Hold(cloth.name, side, from_s, hand.clock_s), cues


FAMILIES: Mapping[str, Family] = {
    "stir_and_wipe": Family(
        (
            "task",
            "hand",
            "other",
            "shape",
            "rounds",
            "stir_size",
            "wipe_size",
            "bouts",
            "bout",
            "pause",
            "speed",
            "wait",
            "place_x",
            "place_y",
        ),
        _stir_and_wipe,
        _stir_objects,
    ),
}
