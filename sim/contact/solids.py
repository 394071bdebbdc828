"""Solids that an arm must keep out of: table top, head, torso, legs, standing objects.

Analytic shapes a little plainer than the drawn surfaces. Each gives, for round points, their depth
in it and the way out; first order in the gap: exact on the surface, where it is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.kinematics import OUTWARD
from sim.person.torso import torso_grid
from sim.vectors import dots

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Slab:
    """An upright box: low_m, high_m (3,) corners in a frame turned by yaw_rad about the origin."""

    low_m: Floats
    high_m: Floats
    yaw_rad: float = 0.0

    def push(self, points_m: Floats, radii_m: Floats) -> tuple[Floats, Floats]:
        """Depth (n,) [m] of round points (n, 3), (n,), <= 0 is clear, and ways out (n, 3)."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        local = points_m @ turn if self.yaw_rad else points_m
        beyond = local - local.clip(self.low_m, self.high_m)
        gap = np.sqrt(dots(beyond, beyond))
        # Inside, the nearest face: below all lower corners, above all upper corners, is negative.
        faces = np.concatenate([self.low_m - local, local - self.high_m], axis=1)
        nearest = faces.argmax(axis=1)
        inside = gap < 1e-9
        distance = np.where(inside, faces.max(axis=1), gap)
        normals = np.concatenate([-np.eye(3), np.eye(3)])[nearest]
        out = np.where(inside[:, None], normals, beyond / np.maximum(gap, 1e-9)[:, None])
        return radii_m - distance, out @ turn.T if self.yaw_rad else out


@dataclass(frozen=True, eq=False)
class Table:
    """The table top: a slab from top_m down by thickness_m, from near_x_m to far_x_m,
    half_width_m to either side.
    """

    top_m: float
    near_x_m: float
    far_x_m: float
    half_width_m: float
    thickness_m: float

    def slab(self, below_m: float = 0.0, above_m: float = 0.0) -> Slab:
        """The slab, or a slab that is thicker downwards or upwards, so that all of it leads out to
        the other side.
        """
        bottom = self.top_m - self.thickness_m - below_m
        return Slab(
            np.array([self.near_x_m, -self.half_width_m, bottom]),
            np.array([self.far_x_m, self.half_width_m, self.top_m + above_m]),
        )

    def side_of(self, palm_m: Floats) -> Slab:
        """The slab for an arm whose palm is there: out of it on the palm's side of the table.

        A hand that dips through the top comes back up with all its fingers, a hand under the table
        goes down; before the edge there is no such preference.
        """
        over = min(max((float(palm_m[0]) - self.near_x_m) / 0.05, 0.0), 1.0)
        thicker = 0.12 * over
        if float(palm_m[2]) >= self.top_m - 0.5 * self.thickness_m:
            return self.slab(below_m=thicker)
        return self.slab(above_m=thicker)


@dataclass(frozen=True, eq=False)
class Trunk:
    """Chest, belly and waist: a stack of rounded sections, as drawn, in the torso's frame.

    heights_m (s,), ascending; sections (s, 3): middle x, half depth, half breadth [m].
    """

    heights_m: Floats
    sections_m: Floats

    def push(self, points_m: Floats, radii_m: Floats) -> tuple[Floats, Floats]:
        """Depth (n,) [m] of round points (n, 3), (n,) and ways out (n, 3), torso frame."""
        z = points_m[:, 2]
        level_z = z.clip(self.heights_m[0], self.heights_m[-1])
        middle, depth, half = (
            np.interp(level_z, self.heights_m, column) for column in self.sections_m.T
        )
        axes = np.column_stack([depth, half, np.full(len(z), _TRUNK_END_M)]) + radii_m[:, None]
        scaled = np.column_stack([points_m[:, 0] - middle, points_m[:, 1], z - level_z]) / axes
        size = np.abs(scaled)
        # A superellipse: |x|^n + |y|^n + |z|^n = level^n.
        inner = size ** (_TRUNK_EXPONENT - 1.0)
        level = np.maximum(dots(inner, size), 1e-9) ** (1.0 / _TRUNK_EXPONENT)
        slope = np.sign(scaled) * inner / axes
        steep = np.maximum(np.sqrt(dots(slope, slope)), 1e-9)
        out = slope / steep[:, None]
        return (1.0 - level) * level ** (_TRUNK_EXPONENT - 1.0) / steep, out


_TRUNK_EXPONENT = 2.45  # of the drawn sections, on average
_TRUNK_END_M = 0.05  # how far it bulges above its highest and below its lowest section
_TRUNK_H = (-0.30, -0.030)  # of the stature: from the seat to where the shoulders' bar takes over


@lru_cache(maxsize=64)
def trunk(anatomy: Anatomy) -> Trunk:
    """The trunk of a person, from the surface that is drawn."""
    vertices = torso_grid(anatomy).reshape(-1, 3)
    low, high = (share * anatomy.stature_m for share in _TRUNK_H)
    heights = [z for z in np.unique(vertices[:, 2].round(6)).tolist() if low <= z <= high]
    sections = []
    for z in heights:
        ring = vertices[np.abs(vertices[:, 2] - z) < 1e-5]
        front, back = float(ring[:, 0].max()), float(ring[:, 0].min())
        half = 0.5 * float(np.ptp(ring[:, 1]))
        sections.append([0.5 * (front + back), 0.5 * (front - back), half])
    return Trunk(np.array(heights), np.array(sections))


@dataclass(frozen=True, eq=False)
class Solids:
    """A person's head, trunk, and k - 2 round-ended bars about it: arms may bump into them.

    names (k): the body part of each, in this order. Positions (3,), rotations (3, 3) own -> world;
    head_axes_m (3,): its half axes; starts_m, ends_m (k - 2, 3), radii_m (k - 2,).
    """

    names: tuple[str, ...]
    head_m: Floats
    head: Floats
    head_axes_m: Floats
    torso_m: Floats
    torso: Floats
    trunk: Trunk
    starts_m: Floats
    ends_m: Floats
    radii_m: Floats

    def push(self, points_m: Floats, radii_m: Floats) -> tuple[Floats, Floats]:
        """Depth (k, n) [m] of round points (n, 3), (n,), <= 0 is clear, and ways out (k, n, 3)."""
        axes = self.head_axes_m + radii_m[:, None]
        scaled = (points_m - self.head_m) @ self.head / axes
        level = np.maximum(np.sqrt(dots(scaled, scaled)), 1e-6)
        slope = scaled / axes / level[:, None]
        steep = np.maximum(np.sqrt(dots(slope, slope)), 1e-9)
        in_head, off_head = (1.0 - level) / steep, (slope / steep[:, None]) @ self.head.T
        in_trunk, off_trunk = self.trunk.push((points_m - self.torso_m) @ self.torso, radii_m)
        along = self.ends_m - self.starts_m
        offset = points_m - self.starts_m[:, None]
        share = dots(offset, along[:, None]) / dots(along, along)[:, None]
        away = offset - share.clip(0.0, 1.0)[..., None] * along[:, None]
        distance = np.sqrt(dots(away, away))
        return (
            np.concatenate([[in_head, in_trunk], self.radii_m[:, None] + radii_m - distance]),
            np.concatenate(
                [
                    [off_head, off_trunk @ self.torso.T],
                    away / np.maximum(distance, 1e-9)[..., None],
                ]
            ),
        )


def person_solids(
    anatomy: Anatomy, torso_m: Floats, torso: Floats, head_m: Floats, head: Floats
) -> Solids:
    """Head, trunk, shoulders, neck and thighs of a person in `sim.pose`'s frames.

    torso_m, head_m (3,), torso, head (3, 3). The thighs stand still, as they are drawn.
    """
    H, k = anatomy.stature_m, anatomy.stature_m / 1.72
    wide = 0.7 * anatomy.shoulder_half_breadth_m
    bars = np.array(
        [
            *([[0.0, 0.04 * y, -0.008 * k], [0.0, wide * y, -0.047 * k]] for y in OUTWARD),
            [[0.004, 0.0, 0.0], [0.004, 0.0, 0.032]],
        ]
    )
    seat, knee = 0.245 * H + 0.075, 0.285 * H
    thighs = [[[-0.05, 0.09 * y, seat], [0.36, 0.13 * y, knee]] for y in OUTWARD]
    ends = np.concatenate([bars @ torso.T + torso_m, np.array(thighs)])
    half = 0.5 * np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m])
    return Solids(
        names=("head", "torso", "torso", "torso", "neck", "right thigh", "left thigh"),
        head_m=head_m,
        head=head,
        head_axes_m=half,
        torso_m=torso_m,
        torso=torso,
        trunk=trunk(anatomy),
        starts_m=ends[:, 0],
        ends_m=ends[:, 1],
        radii_m=np.array([0.066 * k, 0.066 * k, 0.056, 0.07, 0.07]),
    )


@dataclass(frozen=True, eq=False)
class StandingObject:
    """An object that stands in the room, upright: a box, or a cylinder (round).

    size_m: extents x, y, z; base_m (3,): centre of its base.
    """

    name: str
    size_m: tuple[float, float, float]
    base_m: Floats
    yaw_rad: float
    round: bool

    def depth_m(self, points_m: Floats, radii_m: Floats) -> float:
        """Deepest of round points (n, 3), (n,) in it [m]; <= 0 is clear."""
        sx, sy, sz = self.size_m
        local = points_m - self.base_m
        if not self.round:
            half = np.array([sx / 2, sy / 2, 0.0])
            box = Slab(-half, half + sz * _UP, self.yaw_rad)
            return float(box.push(local, radii_m)[0].max())
        aside = np.hypot(local[:, 0], local[:, 1]) - 0.5 * min(sx, sy)
        past = np.maximum(-local[:, 2], local[:, 2] - sz)
        outside = np.hypot(np.maximum(aside, 0.0), np.maximum(past, 0.0))
        distance = outside + np.minimum(np.maximum(aside, past), 0.0)
        return float((radii_m - distance).max())


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Everything that the arms must keep out of, besides each other."""

    table: Table
    solids: Solids
