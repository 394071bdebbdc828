"""Contact: how deep arms are in each other and in the solids about them.

Hands, forearms and upper arms are capsules with the radii of the drawn skin and sleeves. Natural
neighbours do not count: the parts of one arm, upper arms against the torso and each other, and the
elbow's end of a forearm against the torso.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from sim.anatomy import Anatomy
from sim.contact.arm_shape import (
    FOREARM,
    HAND,
    PART_OF_POINT,
    PARTS,
    SHARE_OF_POINT,
    UPPER_ARM,
    Shape,
    arm_shape,
)
from sim.contact.capsules import overlaps
from sim.contact.solids import Obstacles, Slab
from sim.person.kinematics import Arm
from sim.pose import SIDES

ALLOWED_PENETRATION_M = 0.005


_BESIDE_TORSO = 0.3  # share of the forearm, from the elbow, that may rest against the torso

_FIRST_BARS, _FIRST_POINTS = (0, 19, 23), (0, 47, 56)  # where each part begins
_CLEAR_M = -1.0  # depth of a pair that does not count

Flags = NDArray[np.bool_]


class Unposable(BenchError):
    """A motion whose parts cannot be kept apart: the seed is rejected."""


@lru_cache(maxsize=8)
def exempt(names: tuple[str, ...]) -> Flags:
    """Flags (k, 58) of the points that do not count against solids of these names (k)."""
    free = np.zeros((len(names), len(PART_OF_POINT)), dtype=bool)
    for row, name in enumerate(names):
        if name != "head":
            free[row] |= PART_OF_POINT == UPPER_ARM
        if name == "torso":
            free[row] |= (PART_OF_POINT == FOREARM) & (SHARE_OF_POINT < _BESIDE_TORSO)
    free.flags.writeable = False
    return free


def solid_depths(
    shape: Shape, points_m: Floats, obstacles: Obstacles, table: Slab
) -> tuple[Floats, Floats]:
    """Depths (k + 1, 58) [m] of an arm's points in the k solids and in the table, the last row, and
    the ways out (k + 1, 58, 3). Points that do not count are clear.
    """
    depth, out = obstacles.solids.push(points_m, shape.point_radii_m)
    depth[exempt(obstacles.solids.names)] = _CLEAR_M
    on_table, off = table.push(points_m, shape.point_radii_m)
    on_table[PART_OF_POINT == UPPER_ARM] = _CLEAR_M
    return np.concatenate([depth, on_table[None]]), np.concatenate([out, off[None]])


@dataclass(frozen=True, eq=False)
class Penetration:
    """Deepest overlap [m] of each pair of parts, by their names; <= 0 is clear."""

    pairs: Mapping[tuple[str, str], float]

    @property
    def worst(self) -> tuple[str, str]:
        """The pair that overlaps most."""
        return max(self.pairs, key=self.pairs.__getitem__)

    @property
    def worst_m(self) -> float:
        """The deepest overlap of all pairs [m]."""
        return self.pairs[self.worst]

    @property
    def hands_m(self) -> float:
        """Overlap of the hands [m]."""
        return self.pairs[part_name(0, HAND), part_name(1, HAND)]


def part_name(side: int, part: int) -> str:
    """The name of a part, such as "right forearm"."""
    return f"{SIDES[side]} {PARTS[part]}"


def penetration(
    anatomy: Anatomy, arms: tuple[Arm, Arm], curls: Floats, obstacles: Obstacles
) -> Penetration:
    """Depths of both arms (curls (2, 5)) in the obstacles and in each other."""
    shapes = tuple(arm_shape(anatomy, side, curls[side]) for side in (0, 1))
    overlap, _, _ = overlaps(shapes[0].bars(arms[0]), shapes[1].bars(arms[1]))
    by_part = np.maximum.reduceat(
        np.maximum.reduceat(overlap, _FIRST_BARS, axis=0), _FIRST_BARS, axis=1
    )
    pairs = {
        (part_name(0, a), part_name(1, b)): float(by_part[a, b])
        for a in range(3)
        for b in range(3)
        if a != UPPER_ARM or b != UPPER_ARM
    }
    for side in (0, 1):
        points = shapes[side].points(arms[side])
        depth, _ = solid_depths(shapes[side], points, obstacles, obstacles.table.slab())
        deepest = np.maximum.reduceat(depth, _FIRST_POINTS, axis=1)
        for row, name in enumerate((*obstacles.solids.names, "table")):
            for part in range(3):
                key = (part_name(side, part), name)
                if deepest[row, part] > _CLEAR_M:
                    pairs[key] = max(pairs.get(key, _CLEAR_M), float(deepest[row, part]))
    return Penetration(pairs)
