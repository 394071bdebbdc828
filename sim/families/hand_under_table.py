"""A hand under the table."""

from __future__ import annotations

from collections.abc import Mapping

from sim.motion.carriage import Lean
from sim.motion.motion import MotionPlan, successive
from sim.motion.planner import raised
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD


def _hand_under_table(stage: Stage) -> MotionPlan:
    """Back over the table's near edge beside the belly, down, forward over the thigh; and back."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, room = OUTWARD[side], stage.scene.room
    near, top = room.table_near_x_m, room.table_height_m
    beside = stage.number("beside")

    def at(x: float, y: float, z: float, down: float, inward: float) -> HandState:
        place = [near + x, outward * y, top + z]
        return raised(side, place, inward, down, 0.2, curl=0.3, swivel_rad=0.3)

    # The palm passes the edge this far before it, so that the fingers clear it.
    gap = -0.49 * stage.scene.anatomy.hand_length_m
    over = at(0.02, beside, 0.09, 0.1, 0.3)
    before = at(gap, beside, 0.06, 0.3, 0.3)
    below = at(gap, beside, -0.13, 0.2, 0.3)
    under = at(stage.number("under_x"), stage.number("under_y"), -stage.number("depth"), 0.05, 0.3)
    hands = stage.planners(stage.start_s)
    hand = hands[side]
    begun = hand.clock_s
    hand.move(over, speed)
    hand.move(before, 0.8 * speed)
    hand.move(below, 0.8 * speed)
    hand.move(under, speed)
    arrived = hand.clock_s
    hand.wait(stage.number("under"))
    left = hand.clock_s
    hand.move(below, speed)
    hand.move(before, 0.8 * speed)
    hand.move(over, 0.8 * speed)
    back = stage.rest(side, stage.number("back_x"), stage.number("back_y"))
    hand.move(back, speed, [0.0, 0.0, 0.02])
    cues = successive(
        begun, ("go_under", arrived), ("under_table", left), ("come_back", hand.clock_s)
    )
    # Leaning back makes room between belly and table.
    carriage = Lean(begun, arrived, left, hand.clock_s, forward_rad=-stage.number("back"))
    return stage.plan(hands, cues=cues, carriage=carriage)


FAMILIES: Mapping[str, Family] = {
    "hand_under_table": Family(
        (
            "hand",
            "speed",
            "wait",
            "under",
            "beside",
            "under_x",
            "under_y",
            "depth",
            "back",
            "back_x",
            "back_y",
        ),
        _hand_under_table,
    ),
}
