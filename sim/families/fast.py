"""Fast motion, which a tracker's gate must follow: a ladder of speeds, stops, reversals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.event_names import speed_name
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import RISING_M, HandPlanner, meet, raised
from sim.motion.stage import STILL_S, Family, Stage
from sim.motion.strokes import (
    Glide,
    HandState,
    minimum_jerk,
    minimum_jerk_rate,
    minimum_jerk_second,
)
from sim.person.kinematics import OUTWARD
from sim.pose import SIDES

RUNGS = 9


def _speed_ladder(stage: Stage) -> MotionPlan:
    """A hand goes to and fro along a line, rung after rung faster; the other hand rests."""
    side = stage.side("hand")
    outward, rng = OUTWARD[side], stage.streams("ladder")
    hands = stage.planners(STILL_S)
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
    hand.move(ends[0], 0.3, RISING_M)
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
        cues.append(Cue(speed_name(speed), begun, hand.clock_s))
    hand.wait(stage.number("pause"))
    hand.move(stage.rest(side), 0.3, RISING_M)
    return stage.plan(hands, cues=tuple(cues))


def _broken_off(hand: HandPlanner, before: HandState, s: float, brake_s: float) -> float:
    """Break off the hand's last move, a straight stroke from `before`, at share s of its time.

    The hand comes to rest on its way within brake_s. Returns the share of the way done by then.
    """
    stroke = hand.moves[-1]
    way, T = stroke.to.position_m - before.position_m, stroke.end_s - stroke.start_s
    share, rate = minimum_jerk(s), minimum_jerk_rate(s) / T
    # Half of speed x time: a brake that neither overshoots nor creeps.
    done = share + 0.5 * brake_s * rate
    brake = Glide(
        start_s=stroke.start_s + s * T,
        duration_s=brake_s,
        to=replace(stroke.to, position_m=before.position_m + done * way),
        velocity_mps=rate * way,
        acceleration_mps2=(minimum_jerk_second(s) / (T * T)) * way,
        begun=before,
        begun_share=share,
        begun_rate=rate,
    )
    hand.moves.append(brake)
    hand.clock_s = brake.end_s
    return done


def _free(stage: Stage, side: int, share: Floats) -> HandState:
    """A hand in the space before its own shoulder: share (3,) of it, 0-1 along x, outward, z."""
    ahead, out, up = share.tolist()
    place = [
        stage.number("centre_x") + 0.07 * (ahead - 0.5),
        OUTWARD[side] * (stage.number("inner_y") + stage.number("width") * out),
        stage.scene.room.table_height_m + 0.11 + stage.number("tall") * up,
    ]
    return raised(side, place, 0.45, 0.05, 0.6, curl=0.2)


def _stop_and_reverse(stage: Stage) -> MotionPlan:
    """Both hands stroke, each on its own side; most strokes stop dead or turn back midway."""
    slow, fast = stage.number("slowest"), stage.number("fastest")
    hands = stage.planners(stage.start_s)
    cues = []
    for side in (0, 1):
        hand, rng = hands[side], stage.streams(f"strokes-{side}")
        at = np.array([0.5, 0.3 + 0.4 * rng.random(), 0.3 + 0.4 * rng.random()])
        hand.move(_free(stage, side, at), 0.4, RISING_M)
        while hand.clock_s < stage.duration_s:
            # The same draws whatever the kind: a longer sequence begins like a shorter sequence.
            kind = str(rng.choice(["stop", "reverse", "whole"], p=[0.4, 0.4, 0.2]))
            speed = slow * (fast / slow) ** rng.random()
            s, brake = rng.uniform(0.4, 0.62), stage.number("brake") * rng.uniform(0.8, 1.25)
            pause, far = stage.number("pause") * rng.uniform(0.5, 1.5), rng.random(3)
            # Nearly half of the room across at least, so that no stroke is short.
            over = 0.45 + 0.4 * far[1]
            goal = np.array([far[0], at[1] + (over if at[1] < 0.5 else -over), far[2]])
            goal = np.clip(goal, 0.0, 1.0)
            begun, before = hand.clock_s, hand.state
            hand.move(_free(stage, side, goal), speed)
            if kind != "whole":
                goal = at + _broken_off(hand, before, s, brake) * (goal - at)
            if kind == "reverse":
                hand.move(before, speed)
            else:
                at = goal
            cues.append(Cue(f"{kind}:{SIDES[side]}", begun, hand.clock_s))
            hand.wait(pause)
    return stage.plan(hands, cues=tuple(cues))


def _fast_finish(stage: Stage) -> MotionPlan:
    """The hands merge; then both stroke, ever faster, apart and half over each other."""
    front, gap = stage.side("front"), stage.number("depth_gap")
    slow, fast = stage.number("slowest"), stage.number("fastest")
    top, x = stage.scene.room.table_height_m, stage.number("centre_x")
    hands = stage.planners(stage.start_s)

    def near_middle(side: int, across: float, up: float) -> HandState:
        # Along a line of sight the hand behind is lower.
        ahead = 0.5 if side == front else -0.5
        place = [x + ahead * gap, OUTWARD[side] * across, top + up + 0.5 * ahead * gap]
        return raised(side, place, 0.9, -0.1, 0.9, curl=0.2)

    for side in (0, 1):
        ready = _free(stage, side, np.array([0.5, 0.3, 0.3]))
        hands[side].move(ready, 0.4, RISING_M)
    for hand in hands:
        hand.until(max(h.clock_s for h in hands))
        hand.wait(0.3)
    begun = hands[0].clock_s
    for side in (0, 1):
        merged = near_middle(side, 0.5 * stage.number("merge_gap"), 0.16)
        hands[side].move(merged, stage.number("merge_speed"))
    meet(hands, stage.number("merge"))
    cues = [Cue("merge", begun, hands[0].clock_s)]
    left_s = hands[0].clock_s
    rng, over = stage.streams("strokes"), False
    while min(hand.clock_s for hand in hands) < stage.duration_s:
        # The nearer the end, the faster; on the last third, as fast as it gets.
        share = min(1.5 * (hands[0].clock_s - left_s) / (stage.duration_s - left_s), 1.0)
        speed = slow * (fast / slow) ** share
        began = max(hand.clock_s for hand in hands)
        for side in (0, 1):
            hand, free, aside = hands[side], rng.random(3), rng.random(2)
            free[1] = 0.4 + 0.6 * free[1]
            goal = _free(stage, side, free)
            if over:
                goal = near_middle(side, 0.02 + 0.06 * aside[0], 0.14 + 0.1 * aside[1])
            hand.until(began)
            hand.wait(0.12 * rng.random())
            hand.move(goal, speed * rng.uniform(0.85, 1.0), least_s=0.1)
        ended = max(hand.clock_s for hand in hands)
        cues.append(Cue("strokes:over" if over else "strokes:apart", began, ended))
        over = not over
    return stage.plan(hands, cues=tuple(cues))


_SPACE = ("centre_x", "inner_y", "width", "tall")


FAMILIES: Mapping[str, Family] = {
    "speed_ladder": Family(
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
        _speed_ladder,
    ),
    "stop_and_reverse": Family(
        (*_SPACE, "slowest", "fastest", "brake", "pause", "wait"), _stop_and_reverse
    ),
    "fast_finish": Family(
        (
            *_SPACE,
            "slowest",
            "fastest",
            "front",
            "depth_gap",
            "merge",
            "merge_gap",
            "merge_speed",
            "wait",
        ),
        _fast_finish,
    ),
}
