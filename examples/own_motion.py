"""A kind of motion of one's own: a hand knocks on the table.

In this folder: `pjpdaf-bench plugin check --kind motion own_motion:knock`, then
`pjpdaf-bench run own_motion:knock --set times=5`; docs/own_motion.md.
"""

from __future__ import annotations

from sim.families.plugged import OwnMotion
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import raised
from sim.motion.stage import Stage
from sim.person.kinematics import OUTWARD


def plan_knock(stage: Stage) -> MotionPlan:
    """The hand rises as a fist over its place, comes down some times, and rests."""
    side, speed = stage.side("hand"), stage.number("speed")
    hands = stage.planners(stage.start_s)
    hand, top = hands[side], stage.scene.room.table_height_m
    x, y = stage.number("rest_x") + 0.05, OUTWARD[side] * stage.number("rest_y")
    up = raised(side, [x, y, top + stage.number("height")], 0.4, 0.0, 1.2, curl=0.8)
    down = raised(side, [x, y, top + 0.06], 0.4, 0.0, 1.2, curl=0.8)
    hand.move(up, speed, [0.0, 0.0, 0.02])
    begun = hand.clock_s
    for _ in range(round(stage.number("times"))):
        hand.move(down, speed)
        hand.move(up, speed)
    cues = (Cue("knock", begun, hand.clock_s),)
    hand.move(stage.rest(side), speed, [0.0, 0.0, 0.02])
    return stage.plan(hands, cues=cues)


def knock() -> OwnMotion:
    return OwnMotion(
        parameters={
            "hand": {"choices": ["right", "left"], "meaning": "the hand that knocks"},
            "speed": {
                "unit": "m/s",
                "range": [0.2, 1.5],
                "nominal": {"kind": "uniform", "low": 0.4, "high": 0.8},
                "meaning": "peak speed of the strokes",
            },
            "height": {
                "unit": "m",
                "range": [0.1, 0.25],
                "nominal": {"kind": "uniform", "low": 0.12, "high": 0.18},
                "meaning": "of the fist above the table between knocks",
            },
            "times": {
                "unit": "1",
                "range": [1, 10],
                "nominal": {"kind": "uniform", "low": 2, "high": 5},
                "meaning": "how often it knocks",
            },
            "wait": {
                "unit": "s",
                "range": [0, 5],
                "nominal": {"kind": "uniform", "low": 0.2, "high": 1},
                "meaning": "stillness before the hand rises, after the first 1.1 s",
            },
        },
        plan=plan_knock,
        frames=36,
        summary="A fist knocks on the table.",
    )
