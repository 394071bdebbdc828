"""Fast motion: what a gate must follow."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sim.kinematics import OUTWARD
from sim.motion import Cue, Plan
from sim.planner import HandPlanner, raised
from sim.stage import STILL_S, Gesture, Stage, no_objects

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


FAMILIES: Mapping[str, Gesture] = {
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
        no_objects,
        _speed_ladder,
    ),
}
