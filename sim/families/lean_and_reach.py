"""The torso leans and a hand reaches far out on the table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sim.contact.arm_shape import height_above_table
from sim.motion.carriage import Leans
from sim.motion.motion import Cue, MotionPlan, successive
from sim.motion.planner import curled
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation


def _out_there(stage: Stage, side: int, x_m: float, aside_m: float) -> HandState:
    """A hand flat on the table, x_m ahead of the upright shoulders and aside_m out."""
    turned = hand_rotation(side, 0.1, 0.05, 0.1)
    curls = curled(0.12, thumb=0.1)
    lies = height_above_table(stage.scene.anatomy, side, turned, curls) + 1e-3
    place = [x_m, OUTWARD[side] * aside_m, stage.scene.room.table_height_m + lies]
    return HandState(np.array(place), quaternion_of(turned), curls)


def _lean_and_reach(stage: Stage) -> MotionPlan:
    """The torso leans and a hand reaches far out on the table, and back; some times over."""
    rng = stage.streams("reaches")
    hands = stage.planners()
    speed, lean = stage.number("speed"), stage.number("lean")
    moves: list[tuple[float, float, float, float, float]] = []
    cues: list[Cue] = []
    clock, side = stage.start_s, stage.side("hand")
    for turn in range(round(stage.number("reaches"))):
        # The first lean is the declared lean; the others are a little less.
        forward = lean * (1.0 if turn == 0 else float(rng.uniform(0.75, 1.0)))
        sideways = stage.number("sideways") * float(rng.uniform(-1.0, 1.0))
        twist = -OUTWARD[side] * stage.number("twist") * float(rng.uniform(0.3, 1.0))
        far = stage.number("reach") * float(rng.uniform(0.93, 1.0))
        aside = float(rng.uniform(0.05, 0.25))
        hand = hands[side]
        hand.until(clock)
        reach = hand.move(
            _out_there(stage, side, far, aside), speed, [0.0, OUTWARD[side] * 0.02, 0.06]
        )
        # The body leans for as long as the hand goes, a little ahead of it.
        ahead = 0.1 * reach.duration_s
        moves.append((clock, reach.duration_s - ahead, forward, sideways, twist))
        hand.wait(stage.number("hold") * float(rng.uniform(0.7, 1.3)))
        back_s = hand.clock_s
        back = hand.move(stage.rest(side), speed, [0.0, OUTWARD[side] * 0.02, 0.06])
        moves.append((back_s + ahead, back.duration_s - ahead, 0.0, 0.0, 0.0))
        cues += successive(clock, ("lean", reach.end_s), ("leant", back_s), ("back", back.end_s))
        clock = hand.clock_s + stage.number("wait") * float(rng.uniform(0.6, 1.4))
        side = 1 - side if rng.random() < 0.6 else side
    return stage.plan(hands, cues=tuple(cues), carriage=Leans(tuple(moves)))


FAMILIES: Mapping[str, Family] = {
    "lean_and_reach": Family(
        ("hand", "speed", "lean", "sideways", "twist", "reach", "reaches", "hold", "wait"),
        _lean_and_reach,
    ),
}
