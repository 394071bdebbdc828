"""A hand that touches the face."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.families.on_head import Laying, beside, laid_alone
from sim.motion.curves import sweep
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import curled
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD
from sim.pose import SIDES

# Where a hand touches the face, towards the hand's own side, and where its fingers then point.
SPOTS: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "cheek": ((0.72, 0.62, -0.30), (-0.25, -0.35, 1.0)),
    "chin": ((0.86, 0.10, -0.66), (-0.1, -0.7, 0.7)),
    "mouth": ((0.95, 0.02, -0.58), (0.0, -1.0, 0.65)),
    "forehead": ((0.85, 0.10, 0.42), (0.0, -1.0, 0.75)),
}


def on_face(stage: Stage, side: int, place: str, jitter: Floats) -> HandState:
    """A hand with its fingers on a place of the face; jitter (3,) moves the place."""
    mirror = np.array([1.0, OUTWARD[side], 1.0])
    spot, fingers = (mirror * np.array(v) for v in SPOTS[place])
    long, broad = stage.scene.anatomy.hand_length_m, stage.scene.anatomy.hand_breadth_m
    # The middle of the two middle fingers.
    pad = np.array([0.36 * long, 0.0, -0.10 * broad])
    laying = Laying(spot + jitter, fingers, pad, curled(0.2, thumb=0.15))
    return laid_alone(stage, side, laying, stage.number("elbow_out"))


def before_face(side: int, begun: HandState, on: HandState) -> tuple[HandState, HandState]:
    """States on a hand's way from `begun` to where it touches the face: half-way, and near."""
    near = beside(on, 0.05, np.array([0.02, 0.0, -0.03]))
    out = 0.12 * np.array([1.0, OUTWARD[side] * 0.6, 0.0])
    half = 0.5 * (begun.position_m + near.position_m) + out
    return replace(near, position_m=half, with_head=0.0, air=1.0), near


def _touch_face(stage: Stage) -> MotionPlan:
    """A hand goes to the face, stays, comes back; some times over."""
    rng = stage.streams("touches")
    hands = stage.planners()
    cues: list[Cue] = []
    wanted, which = str(stage.values["place"]), str(stage.values["hand"])
    order = [str(place) for place in rng.permutation(list(SPOTS))]
    clock = stage.start_s
    for turn in range(round(stage.number("touches"))):
        chance = int(rng.integers(2))
        side = {"right": 0, "left": 1}.get(which, chance)
        place = order[turn % len(order)] if wanted == "any" else wanted
        speed = stage.number("speed") * float(rng.uniform(0.8, 1.0))
        stay = float(rng.uniform(stage.number("stay_least"), stage.number("stay_most")))
        jitter = rng.uniform(-0.06, 0.06, 3)
        hand = hands[side]
        hand.until(clock)
        begun = hand.clock_s
        on = on_face(stage, side, place, jitter)
        rest = stage.rest(side)
        half, near = before_face(side, rest, on)
        hand.add(sweep(hand.clock_s, (hand.state, half, near, on), speed))
        touched = hand.clock_s
        hand.wait(stay)
        left = hand.clock_s
        hand.add(sweep(left, (on, near, half, rest), 0.9 * speed))
        cues += [
            Cue(f"to_face:{SIDES[side]}", begun, touched),
            Cue(f"on_face:{place}", touched, left),
            Cue(f"from_face:{SIDES[side]}", left, hand.clock_s),
        ]
        clock = hand.clock_s + stage.number("wait") * float(rng.uniform(0.5, 1.5))
    return stage.plan(hands, cues=tuple(cues))


FAMILIES: Mapping[str, Family] = {
    "touch_face": Family(
        ("hand", "place", "touches", "speed", "stay_least", "stay_most", "wait", "elbow_out"),
        _touch_face,
    ),
}
