"""Shapes that are projected: round-ended bars and convex hulls, over the frames of a sequence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND

# What a painted pixel shows. Targets come last: TARGET_PAINT + index of the target.
EMPTY, STANDING, CLOTHED, BARE = 0, 1, 2, 3  # background, what stood there while it was learnt,
TARGET_PAINT = 4  # the person's cloth and hair and moved things, skin that is no target's
PAINTS = TARGET_PAINT + len((HEAD, RIGHT_HAND, LEFT_HAND))


@dataclass(frozen=True, eq=False)
class Bars:
    """n bars over F frames, each between two balls: starts_m, ends_m (F, n, 3); the balls' radii
    start_radii_m, end_radii_m (n,); paints (n,): their class.
    """

    starts_m: Floats
    ends_m: Floats
    start_radii_m: Floats
    end_radii_m: Floats
    paints: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex body over F frames: its points (F, k, 3) and its class. nearer_m: how much nearer
    to the camera than its mean it counts when shapes are ordered by depth. normals (F, 3): of a
    flat body; a bar that is on the camera's side of its plane is before it, any other behind it.
    """

    points_m: Floats
    paint: int
    nearer_m: float = 0.0
    normals: Floats | None = None


def bars_of(starts_m: Floats, ends_m: Floats, radii_m: Floats, paint: int) -> Bars:
    """Bars (F, n, 3) of a class. radii_m (n, 2): at start and end."""
    count = starts_m.shape[1]
    paints = np.full(count, paint, np.uint8)
    return Bars(starts_m, ends_m, radii_m[:, 0], radii_m[:, 1], paints)


def joined(parts: list[Bars]) -> Bars:
    """All bars of these, in order."""
    return Bars(
        np.concatenate([b.starts_m for b in parts], axis=1),
        np.concatenate([b.ends_m for b in parts], axis=1),
        np.concatenate([b.start_radii_m for b in parts]),
        np.concatenate([b.end_radii_m for b in parts]),
        np.concatenate([b.paints for b in parts]),
    )
