"""The hand: palm and five fingers of hinged segments, in the hand frame (numpy only)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.palm import palm_grid, palm_mesh
from sim.surfaces.shapes import Surface, closed_grid, superellipse
from sim.vectors import about_y

FINGERS = ("thumb", "index", "middle", "ring", "little")
_LENGTH, _BREADTH, _PALM = 0.1875, 0.0851, 0.0774  # of the average hand the numbers are drawn for
PALM_SHARE = 0.5  # of the width of the hand's texture; right of it a strip a finger
_SIDES, _RINGS, _END_RINGS = 12, 7, 3  # of a segment: round it, between its joints, in its ends


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
        """A surface for each segment, from its joint along x; its texture is the finger's strip."""
        return tuple(self._surface(segment) for segment in range(3))

    def segment_grid(self, segment: int) -> Floats:
        """Points (rings, sides + 1, 3) of a segment: round ends about its joints, narrow between.

        The back is flatter than a cylinder, the inside has a pad, most at the finger's tip.
        """
        length = self.lengths_m[segment]
        r0, r1 = self.radii_m[segment], self.radii_m[segment + 1]
        arc = np.linspace(0.0, np.pi / 2, _END_RINGS + 1)[:-1]
        share = np.linspace(0.0, 1.0, _RINGS)
        x = np.concatenate([-r0 * np.cos(arc), share * length, length + r1 * np.cos(arc[::-1])])
        between = r0 + (r1 - r0) * share * share * (3.0 - 2.0 * share)
        r = np.concatenate([r0 * np.sin(arc), between, r1 * np.sin(arc[::-1])])
        if segment == 0 and self.name == "thumb":  # its root lies within the ball of the thumb
            r = r * np.interp(x / length, [0.0, 0.7], [0.80, 1.0])
        middle = np.sin(np.pi * np.clip(x / length, 0.0, 1.0))
        narrow, flat, pad = _SHAPE[segment]
        circle = superellipse(_SIDES, 2.0)
        grid = np.empty((len(x), _SIDES + 1, 3))
        grid[..., 0] = x[:, None]
        grid[..., 1] = (r * (1.0 - narrow * middle))[:, None] * circle[:, 0]
        high, low = (1.0 - flat * middle)[:, None], (1.0 + pad * middle)[:, None]
        grid[..., 2] = r[:, None] * np.where(circle[:, 1] > 0.0, high, low) * circle[:, 1]
        return grid

    def _surface(self, segment: int) -> Surface:
        grid = self.segment_grid(segment)
        surface = closed_grid(grid[::-1])
        along = grid[..., 0] - grid[0, 0, 0]
        round_ = np.broadcast_to(np.linspace(0.0, 1.0, _SIDES + 1), along.shape)
        uv = strip_uv(FINGERS.index(self.name), segment, along / along.max(), round_)[::-1]
        return Surface(surface.vertices_m, surface.normals, uv.reshape(-1, 2), surface.faces)


# Of the three segments: how much narrower than a cone, flatter on the back, fuller inside they are.
_SHAPE = ((-0.03, 0.05, 0.06), (0.045, 0.07, 0.07), (0.0, 0.09, 0.10))


def strip_uv(finger: int, segment: int, along: Floats, around: Floats) -> Floats:
    """Texture coordinates (..., 2) of shares 0-1 along a segment, end to end, and around it.

    Around: from +y over the back of the finger.
    """
    u = PALM_SHARE + (1.0 - PALM_SHARE) * (segment + 0.02 + 0.96 * along) / 3.0
    return np.stack([u, (finger + 0.02 + 0.96 * around) / len(FINGERS)], axis=-1)


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


def placed_segments(
    finger: Finger, curl: float, joint_m: Floats, rotation: Floats
) -> Iterator[tuple[Surface, Floats, Floats, Floats]]:
    """Each segment of a curled finger: surface, joint (3,), rotation (3, 3), and its end (3,).

    joint_m, rotation: the finger's base, and its frame when it is straight; of the right hand.
    """
    angles = joint_angles(finger, curl)
    for surface, length, angle in zip(finger.segments(), finger.lengths_m, angles, strict=True):
        rotation = rotation @ about_y(float(angle))
        end_m = joint_m + length * rotation[:, 0]
        yield surface, joint_m, rotation, end_m
        joint_m = end_m


def palm_surface(anatomy: Anatomy) -> Surface:
    """Wrist, palm and webs of the right hand; mirror y for the left."""
    broad = anatomy.hand_breadth_m / _BREADTH
    grid = palm_grid()
    x = grid[..., 0]
    long = np.where(x < 0.0, anatomy.wrist_to_palm_m / _PALM, anatomy.hand_length_m / _LENGTH)
    rings, columns = x.shape
    v, u = np.mgrid[0 : 1 : rings * 1j, 0 : PALM_SHARE : columns * 1j]
    scale = np.stack([long, np.full_like(x, broad), np.full_like(x, broad)], axis=-1)
    return palm_mesh(grid * scale, np.stack([0.01 + 0.98 * u, v], axis=-1))


def mirrored(surface: Surface) -> Surface:
    """The surface with y reversed (right -> left), faces still outwards."""
    flip = np.array([1.0, -1.0, 1.0])
    return Surface(
        surface.vertices_m * flip, surface.normals * flip, surface.uv, surface.faces[:, ::-1].copy()
    )
