"""Targets of gestures: points in the world of places on the table, by objects, on the body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pjpdaf.arrays import Floats
from sim.families.gestures.gesture import Target
from sim.motion.posture import posture
from sim.person.kinematics import OUTWARD, shoulders

if TYPE_CHECKING:
    from sim.families.gestures.rehearsal import Rehearsal

# On the head's surface, in shares of its half axes (x out of the face, y outward, z to the crown).
_ON_HEAD: Mapping[str, tuple[float, float, float]] = {
    "mouth": (0.86, 0.0, -0.52),
    "chin": (0.80, 0.0, -0.80),
    "nose": (1.05, 0.0, -0.15),
    "forehead": (0.90, 0.0, 0.42),
    "ear": (0.0, 1.0, -0.05),
    "crown": (0.0, 0.0, 1.0),
}


def outward(side: int, offset_m: tuple[float, float, float]) -> Floats:
    """World components (3,) of an offset that is ahead, to the side's own side, and up."""
    ahead, aside, up = offset_m
    offset: Floats = np.array([ahead, OUTWARD[side] * aside, up])
    return offset


def point_of(rehearsal: Rehearsal, target: Target, side: int) -> Floats:
    """The point (3,) of a target for the hand of a side, the person upright and both hands at rest.

    The table's points are above its top, an object's above the foot that it now stands on.
    """
    return _origin(rehearsal, target, side) + outward(side, target.offset_m)


def _origin(rehearsal: Rehearsal, target: Target, side: int) -> Floats:
    """The point (3,) from which a target's offset counts."""
    stage = rehearsal.stage
    if target.kind == "table":
        return np.array([0.0, 0.0, stage.scene.room.table_height_m])
    if target.kind == "object":
        return rehearsal.places[target.name].position_m
    anatomy = stage.scene.anatomy
    torso, head = posture(anatomy, (stage.rest(0), stage.rest(1)), np.zeros(3))
    if target.name in _ON_HEAD:
        half = 0.5 * np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m])
        spot = np.array(_ON_HEAD[target.name]) * [1.0, OUTWARD[side], 1.0] * half
        on_head: Floats = head.position_m + head.rotation @ spot
        return on_head
    if target.name == "shoulder":
        return shoulders(anatomy, torso.position_m, torso.rotation)[side]
    # The middle of the breastbone, on the shirt.
    k = anatomy.stature_m / 1.72
    chest: Floats = torso.position_m + torso.rotation @ np.array([0.11 * k, 0.0, -0.14 * k])
    return chest
