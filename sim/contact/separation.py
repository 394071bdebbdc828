"""Contact projection: moves palms and elbows until nothing overlaps by more than it may.

Damped least squares: every overlap asks for a move of its own depth along its way out, palms and
elbows follow as the bones let them, and the least moves that satisfy all are taken. A push grows
from nothing with its depth, so that a motion stays continuous where a contact begins and ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.contact.arm_shape import (
    BOTH_UPPER,
    FOREARM,
    HAND,
    PART_OF_BAR,
    PART_OF_POINT,
    SHARE_OF_BAR,
    SHARE_OF_POINT,
    Shape,
    arm_shape,
)
from sim.contact.capsules import contacts
from sim.contact.contact import solid_depths
from sim.contact.solids import Obstacles
from sim.person.kinematics import MAX_SWIVEL_RAD, OUTWARD, Arm
from sim.vectors import norm

Solve = Callable[[int, Floats, float | None], Arm]  # side, palm (3,), swivel (None = the habit)

_LEFT_ALONE_M = 0.0005  # of overlap: nothing is pushed for less
# Beyond that, rounds go on down to _DONE_M, and are taken in part, less and less, from twice as
# much: where another round begins, the motion makes no step.
_DONE_M = 0.0001
_LEAST_SHARE = 0.02  # of a round: the projection stops
_ROUNDS = 32
# Many small moves, each well damped: they follow a smooth flow out of a deep overlap, where long
# pushes would jump between ways out from one moment to the next.
_LONGEST_PUSH_M = 0.010
_DAMPING, _LEAST_DAMPING = 0.6, 0.02  # of a deep overlap, of an overlap nearly gone
_STEADY = 0.8  # share of a hand's way that does not turn over with its fingers
_EASE_M = 0.002  # depth at which a push has half its weight
_ELBOW_EASE = 4.0  # an elbow swings so much more readily than a palm leaves its target
_LEAST_RADIUS_M = 0.05  # of the elbow's circle: a straight arm's elbow would move without end
_EYE = np.eye(3)
_PUSHING = ~BOTH_UPPER


def _on_wrist(part: Floats, share: Floats) -> Floats:
    """Share (n, 1) of the wrist's move that points of these parts make."""
    moved: Floats = np.where(part == HAND, 1.0, np.where(part == FOREARM, share, 0.0))[:, None]
    return moved


def _on_elbow(part: Floats, share: Floats) -> Floats:
    """Share (n,) of the elbow's move that points of these parts make."""
    moved: Floats = np.where(part == HAND, 0.0, np.where(part == FOREARM, 1.0 - share, share))
    return moved


_POINT_WRIST = _on_wrist(PART_OF_POINT, SHARE_OF_POINT)
_POINT_ELBOW = _on_elbow(PART_OF_POINT, SHARE_OF_POINT)
_BAR_WRIST = _on_wrist(PART_OF_BAR, SHARE_OF_BAR)
_BAR_ELBOW = _on_elbow(PART_OF_BAR, SHARE_OF_BAR)


def _elbow_moves(arm: Arm) -> Floats:
    """How the elbow moves (3, 4) with the wrist, whose bones turn about the shoulder as it goes
    round and fold as it comes near, and with its own swing [m/m].
    """
    reach = arm.wrist_m - arm.shoulder_m
    upper, fore = arm.elbow_m - arm.shoulder_m, arm.wrist_m - arm.elbow_m
    d = norm(reach)
    axis = reach / d
    along = float(upper @ axis)
    aside = upper - along * axis
    radius = max(norm(aside), _LEAST_RADIUS_M)
    # Law of cosines, differentiated: how far along the line to the wrist the elbow goes with it.
    grows = (d * d - float(upper @ upper) + float(fore @ fore)) / (2.0 * d * d)
    folds = grows * (axis - (along / radius) * aside / radius)
    column = axis[:, None]
    # A rigid turn by (axis x move) / d takes the elbow along by (that) x upper.
    turns = (along * (_EYE - column * axis) - column * aside) / d
    moves = np.empty((3, 4))
    moves[:, :3] = turns + folds[:, None] * axis
    moves[:, 3] = arm.swing / max(norm(arm.swing), 1e-9)
    return moves


def _far_apart(shapes: tuple[Shape, Shape], arms: tuple[Arm, Arm]) -> bool:
    """Whether no part of one arm can touch the other: spheres about hands, forearms, upper arms."""
    spheres = []
    for shape, arm in zip(shapes, arms, strict=True):
        thick = float(shape.radii_m[len(shape.hand.radii_m) :].max())
        balls = [(arm.palm_m.tolist(), shape.reach_m)]
        for a, b in ((arm.elbow_m, arm.wrist_m), (arm.shoulder_m, arm.elbow_m)):
            balls.append(((0.5 * (a + b)).tolist(), 0.5 * norm(b - a) + thick))
        spheres.append(balls)
    for (x, y, z), r in spheres[0]:
        for (u, v, w), q in spheres[1]:
            if (x - u) ** 2 + (y - v) ** 2 + (z - w) ** 2 < (r + q) ** 2:
                return False
    return True


# Pairs of parts, of the right and of the left arm, whose bars all go the same way.
_STEADY_PAIRS = ((HAND, HAND), (HAND, FOREARM), (FOREARM, HAND))


def _steady_way(arms: tuple[Arm, Arm], first: int, second: int) -> Floats:
    """Unit way (3,) from a part of the left arm to one of the right, for pairs with a hand: it
    does not turn over while fingers slip between fingers. Bones have steady ways of their own.
    """
    right, left = arms
    if second == FOREARM:
        return _from_bone(left, right.palm_m)
    if first == FOREARM:
        return -_from_bone(right, left.palm_m)
    # Without a centre line to part along, each hand goes to its own side.
    apart = right.palm_m - left.palm_m + np.array([0.0, 0.01 * OUTWARD[0], 0.0])
    return np.asarray(apart / max(norm(apart), 1e-9))


def _from_bone(arm: Arm, palm_m: Floats) -> Floats:
    """The unit way from a forearm to the other hand's palm."""
    bone, offset = arm.wrist_m - arm.elbow_m, palm_m - arm.elbow_m
    share = min(max(float(offset @ bone) / float(bone @ bone), 0.0), 1.0)
    away: Floats = offset - share * bone
    return away / max(norm(away), 1e-9)


def _rows(way: Floats, wrist: Floats, elbow: Floats, elbow_moves: Floats) -> Floats:
    """Rows (n, 4) that move points of an arm along their ways (n, 3): palm, elbow's swing."""
    rows: Floats = elbow[:, None] * (way @ elbow_moves)
    rows[:, :3] += wrist * way
    return rows


def _pair_rows(shapes: tuple[Shape, Shape], arms: tuple[Arm, Arm]) -> tuple[Floats, Floats]:
    """Depths (m,) of the overlaps of two arms, and the rows (m, 8) that move them apart."""
    if _far_apart(shapes, arms):
        return np.zeros(0), np.zeros((0, 8))
    met = contacts(shapes[0].bars(arms[0]), shapes[1].bars(arms[1]), _LEFT_ALONE_M, _PUSHING)
    i, j = met.i, met.j
    if not len(i):
        return np.zeros(0), np.zeros((0, 8))
    way = met.between / np.maximum(met.distance_m, 1e-6)[:, None]
    depths = met.overlap_m - _LEFT_ALONE_M
    for first, second in _STEADY_PAIRS:
        chosen = (PART_OF_BAR[i] == first) & (PART_OF_BAR[j] == second)
        if chosen.any():
            # All bars of a hand go the same way, the mean of theirs, each as heavy as it is deep.
            depth = depths[chosen]
            mean = depth @ way[chosen] / depth.sum()
            common = (1.0 - _STEADY) * mean + _STEADY * _steady_way(arms, first, second)
            way[chosen] = common / max(norm(common), 1e-6)
    rows = np.concatenate(
        [
            _rows(way, _BAR_WRIST[i], _BAR_ELBOW[i], _elbow_moves(arms[0])),
            _rows(-way, _BAR_WRIST[j], _BAR_ELBOW[j], _elbow_moves(arms[1])),
        ],
        axis=1,
    )
    return depths, rows


@dataclass(frozen=True, eq=False)
class _Bumps:
    """The overlaps of an arm with solids and table: depths_m (m,), the rows (m, 8) that move it out
    of them, and spare_m, the way that it may move before it can touch anything.
    """

    arm: Arm
    depths_m: Floats
    rows: Floats
    spare_m: float

    def hold_for(self, arm: Arm) -> bool:
        """Whether they cannot have changed: the arm was clear and has moved less than it had."""
        if self.spare_m <= 0.0:
            return arm is self.arm
        moved = norm(arm.palm_m - self.arm.palm_m) + norm(arm.elbow_m - self.arm.elbow_m)
        return moved < self.spare_m


def _bumps(side: int, shape: Shape, arm: Arm, obstacles: Obstacles) -> _Bumps:
    table = obstacles.table.side_of(arm.palm_m)
    depth, out = solid_depths(shape, shape.points(arm), obstacles, table)
    deepest = float(depth.max())
    if deepest <= _LEFT_ALONE_M:
        return _Bumps(arm, np.zeros(0), np.zeros((0, 8)), -deepest)
    k, n = np.nonzero(depth > _LEFT_ALONE_M)
    rows = np.zeros((len(k), 8))
    rows[:, 4 * side : 4 * side + 4] = _rows(
        out[k, n], _POINT_WRIST[n], _POINT_ELBOW[n], _elbow_moves(arm)
    )
    return _Bumps(arm, depth[k, n] - _LEFT_ALONE_M, rows, 0.0)


def _mobility(arm: Arm, pushed: float) -> float:
    """How readily an elbow swings the way it is pushed: not at all at the end of its range."""
    room = MAX_SWIVEL_RAD - arm.swivel_rad if pushed > 0 else arm.swivel_rad
    return _ELBOW_EASE * min(max(room / 0.15, 0.0), 1.0) + 1e-3


def _step(depth: Floats, rows: Floats, arms: tuple[Arm, Arm]) -> Floats:
    """The move (8,): of the right palm (3), its elbow's swing [m], then the left's."""
    weight = depth / (depth + _EASE_M)
    asked = (weight * np.minimum(depth, _LONGEST_PUSH_M)) @ rows
    ease = np.ones(8)
    for side in (0, 1):
        ease[4 * side + 3] = _mobility(arms[side], float(asked[4 * side + 3]))
    damping = _DAMPING * min(1.0, float(depth.max()) / _LONGEST_PUSH_M) + _LEAST_DAMPING
    system = rows.T @ (weight[:, None] * rows) + np.diag(damping / ease)
    return np.asarray(np.linalg.solve(system, asked))


def separate(
    anatomy: Anatomy,
    palms_m: tuple[Floats, Floats],
    solve: Solve,
    curls: Floats,
    obstacles: Obstacles,
) -> tuple[Arm, Arm]:
    """Arms whose palms are as near to palms_m (2 x (3,)) as contact allows.

    solve(side, palm, swivel) gives an arm. Overlaps that cannot be undone stay as good as it gets:
    `sim.motion.measure.fault_of` judges it.
    """
    shapes = (arm_shape(anatomy, 0, curls[0]), arm_shape(anatomy, 1, curls[1]))
    targets = list(palms_m)
    swivels: list[float | None] = [None, None]
    arms = (solve(0, targets[0], None), solve(1, targets[1], None))
    bumps = [_bumps(side, shapes[side], arms[side], obstacles) for side in (0, 1)]
    for _ in range(_ROUNDS):
        depth, rows = _pair_rows(shapes, arms)
        depth = np.concatenate([depth, *(b.depths_m for b in bumps)])
        share = min(max(float(depth.max(initial=0.0)) / _DONE_M - 1.0, 0.0), 1.0)
        if share < _LEAST_SHARE:
            break
        move = share * _step(depth, np.concatenate([rows, *(b.rows for b in bumps)]), arms)
        solved = list(arms)
        for side in (0, 1):
            palm, swing = move[4 * side : 4 * side + 3], float(move[4 * side + 3])
            if max(norm(palm), abs(swing)) < 1e-7:
                continue
            targets[side] = targets[side] + palm
            swivel = arms[side].swivel_rad
            turned = swivel + swing / max(norm(arms[side].swing), 0.03)
            swivels[side] = min(max(turned, 0.0), max(MAX_SWIVEL_RAD, swivel))
            solved[side] = solve(side, targets[side], swivels[side])
            if not bumps[side].hold_for(solved[side]):
                bumps[side] = _bumps(side, shapes[side], solved[side], obstacles)
        arms = (solved[0], solved[1])
    return arms
