"""Arms where a performer's plan has them, at F moments at once: before contact moves them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Bools, Floats
from sim.motion.motion import HandMotion, Performer, elbow_floor_over
from sim.motion.posture import HandsOver, posture_over
from sim.motion.strokes import HandPath, Wobble
from sim.person.kinematics import OUTWARD
from sim.silhouettes.arms_over import ArmsOver, arms_over
from sim.silhouettes.contact_over import ArmShapes, may_touch, shapes_over


@dataclass(frozen=True, eq=False)
class PlannedArms:
    """Body and arms of a plan at times_s (F,); pairs are right, left.

    torso, head: positions (F, 3), rotations (F, 3, 3); palms_m: of (F, 3), where the plan wants
    them; curls: of (F, 5). may_touch (F,): whether an arm may be in the other, in the body or in
    the table, so that `sim.contact.separation` may move it.
    """

    times_s: Floats
    torso: tuple[Floats, Floats]
    head: tuple[Floats, Floats]
    arms: tuple[ArmsOver, ArmsOver]
    shapes: tuple[ArmShapes, ArmShapes]
    palms_m: tuple[Floats, Floats]
    curls: tuple[Floats, Floats]
    may_touch: Bools


def planned_arms(performer: Performer, times_s: Sequence[float]) -> PlannedArms:
    """The arms of a performer's plan at these times."""
    plan, anatomy, table = performer.plan, performer.scene.anatomy, performer.table
    times = np.array(times_s, dtype=np.float64)
    hands = (_hands_over(plan.hands[0], times), _hands_over(plan.hands[1], times))
    sway = _wobble_over(plan.sway, times)
    torso_m, torso, head_m, head = posture_over(
        anatomy, hands, sway, [plan.carriage.at(t_s) for t_s in times_s]
    )
    arms, shapes, palms = [], [], []
    for side, state in enumerate(hands):
        tremor = _wobble_over(plan.tremor[side], times)
        palm = state.positions_m + state.air[:, None] * tremor + state.with_head[:, None] * sway
        joint = np.array(
            [0.0, OUTWARD[side] * anatomy.shoulder_half_breadth_m, -anatomy.shoulder_drop_m]
        )
        arm = arms_over(
            anatomy,
            side,
            torso_m + torso @ joint,
            palm,
            state.rotations,
            plan.swivel_rad + state.swivel_rad,
            elbow_floor_over(anatomy, table, palm),
            torso[:, :, 0],
        )
        arms.append(arm)
        palms.append(palm)
        shapes.append(shapes_over(anatomy, side, arm, state.curls))
    pair = (shapes[0], shapes[1])
    return PlannedArms(
        times_s=times,
        torso=(torso_m, torso),
        head=(head_m, head),
        arms=(arms[0], arms[1]),
        shapes=pair,
        palms_m=(palms[0], palms[1]),
        curls=(hands[0].curls, hands[1].curls),
        may_touch=may_touch(anatomy, pair, table, (torso_m, torso), (head_m, head)),
    )


def _hands_over(hand: HandMotion, times_s: Floats) -> HandsOver:
    if isinstance(hand, HandPath):
        return HandsOver.of(hand.rows(times_s))
    return HandsOver.of(np.array([hand.at(t_s).row for t_s in times_s.tolist()]))


def _wobble_over(wobble: Wobble, times_s: Floats) -> Floats:
    """Displacements (F, 3)."""
    angles = (2.0 * np.pi * times_s)[:, None, None] * wobble.frequencies_hz + wobble.phases_rad
    return np.asarray((wobble.amplitudes_m * np.sin(angles)).sum(axis=1))
