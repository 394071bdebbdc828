"""A hand that goes behind the head."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.families.on_head import Laying, laid_alone
from sim.motion.curves import sweep
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import HandPlanner, curled
from sim.motion.posture import posture
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandState, between
from sim.person.kinematics import OUTWARD
from sim.pose import SIDES


def _hand_behind_head(stage: Stage) -> MotionPlan:
    """A hand goes behind the head, stays hidden, comes out on its own or on the other side."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, swivel = OUTWARD[side], stage.number("elbow_out")
    hands = stage.planners(stage.start_s)
    hand, rest = hands[side], stage.rest(side)
    behind = laid_alone(
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
        """A hand in the air about the head's centre, turned between rest (0) and behind (1)."""
        turned = replace(between(rest, behind, like), with_head=0.0, air=1.0)
        place = head.position_m + np.array([ahead_m, out_m * outward, up_m])
        return replace(turned, position_m=place, curls=behind.curls)

    before = free(0.30, 0.19, -0.24, 0.15)
    beside = free(0.03, 0.27, 0.03, 0.7)
    # Round the corner of the head, not through it.
    off = np.array([-0.035, 0.085 * outward, 0.0])
    corner = replace(behind.moved(off), with_head=0.7, air=0.3)
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
    """Add the moves from behind the head out at its other side, and back over the crown."""
    outward, swivel, speed = OUTWARD[side], stage.number("elbow_out"), stage.number("speed")
    peeking = laid_alone(
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
    on_crown = laid_alone(
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
    "hand_behind_head": Family(
        ("hand", "out", "speed", "hidden", "times", "peek", "height", "wait", "elbow_out"),
        _hand_behind_head,
    ),
}
