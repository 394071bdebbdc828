"""The hand: palm and five fingers of hinged segments, in the hand frame (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.surfaces.shapes import Surface, capped, closed_grid, interpolate, limb, superellipse

FINGERS = ("thumb", "index", "middle", "ring", "little")
_LENGTH, _BREADTH, _PALM = 0.1875, 0.0851, 0.0774  # of the average hand the numbers are drawn for


@dataclass(frozen=True, eq=False)
class Finger:
    """A chain of three segments of the right hand; mirror y (and the axes' x, z) for the left.

    base_m (3,): the first joint in the hand frame. rotation (3, 3): finger frame -> hand frame, x
    along the straight finger; axis (3,): flexion axis in the finger frame, the same for each joint.
    lengths_m, radii_m: segments, and the radius at each joint and at the tip (4).
    straight_rad, fist_rad (3,): joint angles at curl 0 and 1.
    """

    name: str
    base_m: Floats
    rotation: Floats
    axis: Floats
    lengths_m: tuple[float, float, float]
    radii_m: tuple[float, float, float, float]
    straight_rad: Floats
    fist_rad: Floats

    def segments(self) -> tuple[Surface, ...]:
        """A surface for each segment, from its joint along x."""
        return tuple(
            limb(length, np.array([r0, 0.96 * (r0 + r1) / 2, r1]), sides=10, rings=3, end_rings=3)
            for length, r0, r1 in zip(
                self.lengths_m, self.radii_m[:-1], self.radii_m[1:], strict=True
            )
        )


def fingers(anatomy: Anatomy) -> tuple[Finger, ...]:
    """Thumb, index, middle, ring, little finger of the right hand."""
    long, broad = anatomy.hand_length_m / _LENGTH, anatomy.hand_breadth_m / _BREADTH
    digits = [_thumb(long, broad, anatomy)]
    rows = (
        # name, knuckle x, y, z, splay [deg], length, radius
        ("index", 0.0235, 0.0305, -0.001, 6.0, 0.0720, 0.0092),
        ("middle", 0.0280, 0.0100, 0.001, 1.0, 0.0800, 0.0093),
        ("ring", 0.0235, -0.0105, 0.000, -5.0, 0.0740, 0.0088),
        ("little", 0.0130, -0.0300, -0.003, -12.0, 0.0580, 0.0077),
    )
    for name, x, y, z, splay_deg, length, radius in rows:
        c, s = np.cos(np.radians(splay_deg)), np.sin(np.radians(splay_deg))
        digits.append(
            Finger(
                name=name,
                base_m=np.array([x * long, y * broad, z * broad]),
                rotation=np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]),
                axis=np.array([0.0, 1.0, 0.0]),
                lengths_m=(0.47 * length * long, 0.29 * length * long, 0.20 * length * long),
                radii_m=(
                    radius * broad,
                    0.90 * radius * broad,
                    0.82 * radius * broad,
                    0.68 * radius * broad,
                ),
                straight_rad=np.radians([3.0, 4.0, 3.0]),
                fist_rad=np.radians([82.0, 100.0, 62.0]),
            )
        )
    return tuple(digits)


def _thumb(long: float, broad: float, anatomy: Anatomy) -> Finger:
    along = np.array([0.74, 0.66, -0.05])
    along /= np.linalg.norm(along)
    # Flexion carries the tip over the palm, under the fingers.
    sweep = np.array([0.15, -0.80, -0.58])
    axis = np.cross(along, sweep)
    axis /= np.linalg.norm(axis)
    rotation = np.column_stack([along, axis, np.cross(along, axis)])
    return Finger(
        name="thumb",
        base_m=np.array([-0.052 * anatomy.wrist_to_palm_m / _PALM, 0.022 * broad, -0.004 * broad]),
        rotation=rotation,
        axis=np.array([0.0, 1.0, 0.0]),
        lengths_m=(0.045 * long, 0.034 * long, 0.024 * long),
        radii_m=(0.0150 * broad, 0.0112 * broad, 0.0098 * broad, 0.0078 * broad),
        straight_rad=np.radians([0.0, 6.0, 4.0]),
        fist_rad=np.radians([34.0, 42.0, 55.0]),
    )


def joint_angles(finger: Finger, curl: float) -> Floats:
    """Angles (3,) [rad] of a finger at curl 0 (straight) to 1 (fist)."""
    return np.asarray(finger.straight_rad + curl * (finger.fist_rad - finger.straight_rad))


def palm_surface(anatomy: Anatomy) -> Surface:
    """Wrist and palm of the right hand; mirror y for the left."""
    long = anatomy.hand_length_m / _LENGTH
    broad = anatomy.hand_breadth_m / _BREADTH
    wrist = -anatomy.wrist_to_palm_m
    # x, middle y, half breadth, upper and lower half thickness
    table = np.array(
        [
            [wrist - 0.018, 0.0000, 0.0230, 0.0160, 0.0160],
            [wrist, 0.0000, 0.0250, 0.0165, 0.0165],
            [wrist * 0.70, 0.0010, 0.0290, 0.0155, 0.0175],
            [wrist * 0.35, 0.0010, 0.0360, 0.0140, 0.0165],
            [0.0, 0.0005, 0.0395, 0.0125, 0.0145],
            [0.018 * long, 0.0005, 0.0400, 0.0115, 0.0120],
            [0.030 * long, 0.0030, 0.0335, 0.0085, 0.0090],
            [0.034 * long, 0.0040, 0.0250, 0.0040, 0.0045],
        ]
    )
    x = np.linspace(table[0, 0], table[-1, 0], 17)
    middle, half, upper, lower = (interpolate(table, x) * broad).T
    outline = superellipse(20, 2.6)
    grid = np.empty((len(x), len(outline), 3))
    grid[..., 0] = x[:, None]
    # The knuckles lie on an arc: the little finger's starts nearer to the wrist.
    y = half[:, None] * outline[:, 0]
    grid[..., 1] = middle[:, None] + y
    grid[..., 2] = np.where(
        outline[:, 1] >= 0, upper[:, None] * outline[:, 1], lower[:, None] * outline[:, 1]
    )
    slant = np.clip((x - 0.0) / table[-1, 0], 0, 1)[:, None]
    grid[..., 0] -= slant * 0.014 * long * np.clip(-(y - 0.005) / 0.035, 0, 1.2)
    return closed_grid(capped(grid)[::-1])


def mirrored(surface: Surface) -> Surface:
    """The surface with y reversed (right -> left), faces still outwards."""
    flip = np.array([1.0, -1.0, 1.0])
    return Surface(
        surface.vertices_m * flip, surface.normals * flip, surface.uv, surface.faces[:, ::-1].copy()
    )
