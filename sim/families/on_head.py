"""Hands laid on the head: where they touch it, and how they are turned there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.contact.arm_shape import arm_shape, hand_capsules
from sim.contact.capsules import Capsules
from sim.contact.contact import exempt
from sim.contact.solids import person_solids
from sim.motion.posture import posture
from sim.motion.stage import Stage
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, shoulders, solve_arm
from sim.vectors import about, about_y, cross, dots, norm

_FREE_M = 0.0005  # of air between a hand that touches and the head: nothing to project away


def _half_axes(anatomy: Anatomy) -> Floats:
    return 0.5 * np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m])


def _facing(normal: Floats, fingers: Floats) -> Floats:
    """Rotation (3, 3) of a hand whose palm lies on a surface of this outward normal (3,), with its
    fingers as near to the direction `fingers` (3,) as that allows."""
    along = fingers - float(fingers @ normal) * normal
    along = along / norm(along)
    return np.column_stack([along, cross(normal, along), normal])


def _gaps(bars: Capsules, axes_m: Floats) -> Floats:
    """Air (n,) [m] between hands (n, 19 bars) in the head's frame and the head, an ellipsoid of
    these half axes (3,); below 0 inside.
    """
    middles = 0.5 * (bars.starts_m + bars.ends_m)
    points = np.concatenate([bars.starts_m, middles, bars.ends_m], axis=1)
    axes = axes_m + np.tile(bars.radii_m, 3)[:, None]
    scaled = points / axes
    level = np.sqrt(dots(scaled, scaled))
    steeper = scaled / axes
    steep = np.sqrt(dots(steeper, steeper)) / level
    return np.asarray(((level - 1.0) / steep).min(axis=1))


@dataclass(frozen=True, eq=False)
class Laying:
    """How a hand is to be laid on the head.

    spot (3,): direction of the place on the head's surface, in shares of its half axes; fingers
    (3,): direction in which the fingers should point, head frame; pad (3,): the point of the hand
    that is to lie there, hand frame; air_m: least distance of that point from the head; own_side_m:
    least distance of the hand from the head's mid-plane, on its own side (None: it may cross).
    twists_rad, tilts_rad: angles to choose from, of the fingers along the surface and of the wrist
    off it; the first are preferred.
    """

    spot: Floats
    fingers: Floats
    pad: Floats
    curls: Floats
    air_m: float = -0.05
    own_side_m: float | None = None
    twists_rad: tuple[float, ...] = (0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75)
    tilts_rad: tuple[float, ...] = (0.25, 0.1, 0.45, 0.7)

    def placed(
        self, anatomy: Anatomy, side: int, angles_rad: Sequence[tuple[float, float]]
    ) -> list[tuple[Floats, Floats]]:
        """Palm (3,) [m] and turn (3, 3), head frame: about to touch; for each twist and tilt."""
        axes = _half_axes(anatomy)
        unit = self.spot / norm(self.spot)
        normal = (unit / axes) / norm(unit / axes)
        facing = _facing(normal, self.fingers)
        turns = [about(normal, twist) @ facing @ about_y(tilt) for twist, tilt in angles_rad]
        bases = [axes * unit - turn @ self.pad for turn in turns]
        palms = self._clear_of_head(anatomy, side, bases, turns, normal)
        for k, (base, turn) in enumerate(zip(bases, turns, strict=True)):
            for _ in range(12):
                if self.own_side_m is None:
                    break
                bars = hand_capsules(anatomy, side, self.curls).placed(palms[k], turn)
                ends = OUTWARD[side] * np.stack([bars.starts_m[:, 1], bars.ends_m[:, 1]])
                aside = self.own_side_m - float((ends - bars.radii_m).min())
                if aside < 1e-4:
                    break
                # More than is asked for: the way back to the head leads inward again.
                base[1] += 1.3 * OUTWARD[side] * aside
                (palms[k],) = self._clear_of_head(anatomy, side, [base], [turn], normal)
        return list(zip(palms, turns, strict=True))

    def _clear_of_head(
        self,
        anatomy: Anatomy,
        side: int,
        bases: Sequence[Floats],
        turns: Sequence[Floats],
        normal: Floats,
    ) -> list[Floats]:
        """Palms (3,) from bases (3,) along the normal to where the hands are about to touch."""
        shape, axes = hand_capsules(anatomy, side, self.curls), _half_axes(anatomy)
        starts, ends = (
            np.array([points @ turn.T for turn in turns])
            for points in (shape.starts_m, shape.ends_m)
        )
        base = np.array(bases)
        near, far = np.full(len(base), -0.05), np.full(len(base), 0.15)
        for _ in range(16):  # bisection, of all at once
            middle = 0.5 * (near + far)
            palm = (base + middle[:, None] * normal)[:, None]
            free = _gaps(Capsules(starts + palm, ends + palm, shape.radii_m), axes) >= _FREE_M
            near, far = np.where(free, near, middle), np.where(free, middle, far)
        return list(base + np.maximum(far, self.air_m)[:, None] * normal)


def laid_alone(stage: Stage, side: int, laying: Laying, swivel_rad: float) -> HandState:
    """A hand laid on the head while the other rests."""
    like = replace(stage.rest(side), air=0.1, with_head=1.0, swivel_rad=swivel_rad)
    return laid_on_head(stage, side, laying, like, stage.rest(1 - side))


def beside(touching: HandState, off_m: float, moved_m: Floats) -> HandState:
    """A hand just before or after it lies on the head: off_m off along its back, and moved (3,)."""
    away = touching.position_m + off_m * touching.rotation[:, 2] + moved_m
    swivel = 0.6 * touching.swivel_rad
    return replace(touching, position_m=away, with_head=0.5, air=0.6, swivel_rad=swivel)


def laid_on_head(
    stage: Stage, side: int, laying: Laying, like: HandState, other: HandState
) -> HandState:
    """A hand laid on the head, going with it, turned as its arm can best do it.

    like: a state with the hand's air, nod and swivel; other: the other hand meanwhile.
    """
    anatomy = stage.scene.anatomy
    states = (like, other) if side == 0 else (other, like)
    torso, head = posture(anatomy, states, np.zeros(3))
    shoulder = shoulders(anatomy, torso.position_m, torso.rotation)[side]
    swivel = stage.number("elbow_swivel") + like.swivel_rad
    body = person_solids(anatomy, torso.position_m, torso.rotation, head.position_m, head.rotation)
    shape = arm_shape(anatomy, side, laying.curls)
    best, least = like, math.inf
    chosen = list(product(enumerate(laying.twists_rad), enumerate(laying.tilts_rad)))
    placed = laying.placed(anatomy, side, [(twist, tilt) for (_, twist), (_, tilt) in chosen])
    for ((rank, _), (order, _)), (palm, turn) in zip(chosen, placed, strict=True):
        palm_w, turn_w = head.position_m + head.rotation @ palm, head.rotation @ turn
        arm = solve_arm(anatomy, side, shoulder, palm_w, turn_w, swivel)
        depth, _ = body.push(shape.points(arm), shape.point_radii_m)
        sunk = max(float(depth[~exempt(body.names)].max()), 0.0)
        # 1 mm short or sunk in is as bad as 1 degree that the wrist has to be turned back.
        bent = math.acos(min(1.0, 0.5 * (float(np.trace(arm.hand.T @ turn_w)) - 1.0)))
        cost = 60.0 * (arm.short_m + sunk) + 3.4 * bent + 0.06 * (rank + order)
        if cost < least:
            least = cost
            best = replace(
                like, position_m=palm_w, quaternion=quaternion_of(turn_w), curls=laying.curls
            )
    return best
