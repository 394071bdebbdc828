"""A dark object laid across a hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.contact.arm_shape import hand_capsules, height_above_table
from sim.motion.motion import Cue, Hold, MotionPlan
from sim.motion.planner import HandPlanner, curled
from sim.motion.stage import Family, Stage, Values, number
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import Transform
from sim.specs import ObjectSpec
from sim.vectors import cross, norm

_BEHIND_M = 0.06  # of the tool, beyond the little finger of the hand that holds it

_IN_FIST_M = np.array([0.028, 0.0, -0.022])  # the tool's axis in the hand's frame


def _tool_size(values: Values) -> tuple[float, float, float]:
    if values["what"] == "rod":
        return number(values, "length"), number(values, "thickness"), number(values, "thickness")
    return number(values, "length"), number(values, "breadth"), 0.008


def _tool_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """The tool; it is in the hand from the start, so that its place on the table is never seen."""
    kind = {"rod": "rod", "board": "sheet"}[str(values["what"])]
    dark = (0.07, 0.075, 0.085)
    return (ObjectSpec("tool", kind, _tool_size(values), dark, (0.45, 0.0)),)


def _over_hand(stage: Stage) -> tuple[HandState, HandState, Transform]:
    """The hand that holds the tool: its state at rest, its state with the tool laid over the other
    hand, and the tool in the hand's frame.

    The tool lies across the fingers of the other hand, whichever way that hand is turned.
    """
    side, scene, (tool, _) = stage.side("hand"), stage.scene, stage.object_named("tool")
    anatomy, top, holder = scene.anatomy, scene.room.table_height_m, 1 - side
    lying = stage.rest(side)
    length, breadth, thick = tool.size_m
    up = np.array([0.0, 0.0, 1.0])
    forward = lying.rotation[:, 0] * [1.0, 1.0, 0.0]
    forward = forward / norm(forward)
    across = OUTWARD[side] * np.array([-forward[1], forward[0], 0.0])
    placed = np.column_stack([across, cross(up, across), up])
    shape = hand_capsules(anatomy, side, lying.curls).placed(lying.position_m, lying.rotation)
    under = 0.002 + float((np.maximum(shape.starts_m, shape.ends_m)[:, 2] + shape.radii_m).max())
    # Seen from the cameras, an object that lies higher covers a place further back.
    rig, palm_z = scene.rig, float(lying.position_m[2])
    back = (rig.distance_m - float(lying.position_m[0])) / (rig.height_m - palm_z)
    if stage.values["what"] == "rod":
        line = stage.number("across") + back * (under + 0.5 * thick - palm_z)
    else:  # from the palm's centre to the tips: 0.57 of the hand
        line = 0.57 * anatomy.hand_length_m - stage.number("bare") - 0.5 * breadth
        line += back * (under + thick - palm_z)
    # Its end is a little past the lying hand's outer edge.
    beyond = 0.5 * anatomy.hand_breadth_m + 0.025
    middle = lying.position_m + line * forward + (beyond - 0.5 * length) * across
    middle[2] = under
    rotation = hand_rotation(holder, stage.number("holder_inward"), 0.0, 0.0)
    fist = curled(0.62, thumb=0.5)
    in_fist = middle - (0.5 * length - _BEHIND_M) * across + np.array([0.0, 0.0, 0.5 * thick])
    palm = in_fist - rotation @ _IN_FIST_M
    grip = Transform(rotation.T @ (middle - palm), rotation.T @ placed)
    laid = HandState(palm, quaternion_of(rotation), fist, air=0.0)
    # At rest neither the fist nor the tool is in the table.
    low = max(height_above_table(anatomy, holder, rotation, fist), float(palm[2]) - under) + 0.001
    place = stage.rest(holder, -0.02, 0.06).position_m
    start = replace(laid, position_m=np.array([place[0], place[1], top + low]))
    return start, laid, grip


def _object_splits_hand(stage: Stage) -> MotionPlan:
    """A hand lays its tool across the other, which lies on the table, and takes it back."""
    side, speed = stage.side("hand"), stage.number("speed")
    holder = 1 - side
    start, laid, grip = _over_hand(stage)
    above = replace(laid.moved([0.0, 0.0, stage.number("lift")]), air=1.0)
    hand, lying = HandPlanner(start), HandPlanner(stage.rest(side))
    hand.until(stage.start_s)
    hand.move(above, speed, [0.0, 0.0, 0.04])
    hand.move(laid, 0.5 * speed)
    laid_s = hand.clock_s
    hand.wait(stage.number("hold"))
    lifted_s = hand.clock_s
    hand.move(above, 0.5 * speed)
    hand.move(start, speed, [0.0, 0.0, 0.04])
    # A second more than the film: it is never let go.
    hold = Hold("tool", holder, 0.0, stage.duration_s + 1.0, grip=grip, put_down=False)
    hands = (hand, lying) if holder == 0 else (lying, hand)
    return stage.plan(hands, (hold,), (Cue("covered", laid_s, lifted_s),))


FAMILIES: Mapping[str, Family] = {
    "object_splits_hand": Family(
        (
            "hand",
            "what",
            "length",
            "thickness",
            "breadth",
            "across",
            "bare",
            "holder_inward",
            "speed",
            "wait",
            "hold",
            "lift",
        ),
        _object_splits_hand,
        _tool_objects,
    ),
}
