"""Smooth limits of a recorded motion: above the table, within reach."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.clips.fit import FLOOR_M
from sim.motion.strokes import minimum_jerk_over
from sim.person.kinematics import reach_limits
from sim.specs import RoomSpec

_SOFT_M = 0.012  # how gently limits set in

# At the table top a palm is at least so far beyond its near edge; _FREE_M above it, so far ahead of
# the shoulders: between an elbow behind the back and a hand through the edge.
_OVER_M, _FREE_M, _BESIDE_M = 0.06, 0.35, 0.05


def above(values: Floats, least: Floats | float) -> Floats:
    """Values pressed smoothly above their least values."""
    soft: Floats = least + _SOFT_M * np.logaddexp(0.0, (values - least) / _SOFT_M)
    return soft


def at_a_table(palms: Floats, room: RoomSpec) -> Floats:
    """Palms (n, 2, 3) above the table, and the lower the further over it: no lap, no hips."""
    z = above(palms[..., 2], room.table_height_m + FLOOR_M)
    free = minimum_jerk_over((z - room.table_height_m) / _FREE_M)
    least = (1.0 - free) * (room.table_near_x_m + _OVER_M) + free * _BESIDE_M
    return np.stack([above(palms[..., 0], least), palms[..., 1], z], axis=-1)


def in_reach(palms: Floats, joints: Floats, anatomy: Anatomy) -> Floats:
    """Palms (n, 2, 3) brought smoothly to where the arm from joints (n, 2, 3) reaches."""
    near, far = reach_limits(anatomy.upper_arm_m, anatomy.forearm_m)
    near, far = near + anatomy.wrist_to_palm_m, 0.99 * far + 0.9 * anatomy.wrist_to_palm_m
    offset = palms - joints
    r = np.linalg.norm(offset, axis=2, keepdims=True)
    kept = -above(-above(r, near), -far)
    within: Floats = joints + offset * (kept / np.maximum(r, 1e-6))
    return within


def limited(values: Floats, most: float) -> Floats:
    """Values kept smoothly between -most and most."""
    kept: Floats = most * np.tanh(values / most)
    return kept
