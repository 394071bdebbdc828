"""Capsules: round-ended bars, and how deep they overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Bools, Floats, Ints
from sim.vectors import dots


@dataclass(frozen=True, eq=False)
class Capsules:
    """n round-ended bars: starts_m, ends_m (n, 3), radii_m (n,)."""

    starts_m: Floats
    ends_m: Floats
    radii_m: Floats

    def placed(self, position_m: Floats, rotation: Floats) -> Capsules:
        """The same bars moved by a rigid transform: position (3,), rotation (3, 3)."""
        turn = rotation.T
        return Capsules(
            self.starts_m @ turn + position_m, self.ends_m @ turn + position_m, self.radii_m
        )

    @property
    def lowest_m(self) -> float:
        """The lowest point of all bars along z [m]."""
        return float((np.minimum(self.starts_m[:, 2], self.ends_m[:, 2]) - self.radii_m).min())


def overlaps(a: Capsules, b: Capsules) -> tuple[Floats, Floats, Floats]:
    """Overlap (n, m) of each bar of a with each of b, their axes' distance, and b -> a (n, m, 3).

    All pairs at once; closest points of segments: Ericson, Real-Time Collision Detection 5.1.9.
    Bars (..., n, 3) of many moments give results with the same axes in front.
    """
    p, d1 = a.starts_m[..., :, None, :], (a.ends_m - a.starts_m)[..., :, None, :]
    q, d2 = b.starts_m[..., None, :, :], (b.ends_m - b.starts_m)[..., None, :, :]
    distance, between = _nearest(p, d1, q, d2)
    return a.radii_m[:, None] + b.radii_m[None] - distance, distance, between


@dataclass(frozen=True, eq=False)
class Contacts:
    """k pairs of bars that overlap: i, j (k,) of the two, overlap_m (k,), distance_m (k,) of their
    axes, between (k, 3) from the second to the first.
    """

    i: Ints
    j: Ints
    overlap_m: Floats
    distance_m: Floats
    between: Floats


def contacts(a: Capsules, b: Capsules, least_m: float, counts: Bools) -> Contacts:
    """The pairs of `overlaps` of bars (n, 3) and (m, 3) that overlap by more than least_m >= 0.

    counts (n, m): pairs that do. Most pairs are so far apart that balls about the bars are.
    """
    d1, d2 = a.ends_m - a.starts_m, b.ends_m - b.starts_m
    reach = (0.5 * np.sqrt(dots(d1, d1)) + a.radii_m)[:, None]
    reach = reach + (0.5 * np.sqrt(dots(d2, d2)) + b.radii_m)
    apart = (a.starts_m + 0.5 * d1)[:, None] - (b.starts_m + 0.5 * d2)
    i, j = np.nonzero((dots(apart, apart) < reach * reach) & counts)
    distance, between = _nearest(a.starts_m[i], d1[i], b.starts_m[j], d2[j])
    overlap = a.radii_m[i] + b.radii_m[j] - distance
    deep = overlap > least_m
    return Contacts(i[deep], j[deep], overlap[deep], distance[deep], between[deep])


def _nearest(p: Floats, d1: Floats, q: Floats, d2: Floats) -> tuple[Floats, Floats]:
    """Least distances (...) of segments p to p + d1 and q to q + d2 (..., 3), and the ways there
    (..., 3) from second to first.
    """
    r = p - q
    A, E, F, C, B = dots(d1, d1), dots(d2, d2), dots(d2, r), dots(d1, r), dots(d1, d2)
    denominator = np.maximum(A * E - B * B, 1e-12)
    s = ((B * F - C * E) / denominator).clip(0.0, 1.0)
    t = ((B * s + F) / E).clip(0.0, 1.0)
    s = ((B * t - C) / A).clip(0.0, 1.0)
    between = r + s[..., None] * d1 - t[..., None] * d2
    return np.sqrt(dots(between, between)), between


def capsule_gap(a: Capsules, b: Capsules) -> tuple[float, Floats]:
    """Deepest overlap of any bar of a with any of b [m], <= 0 is clear, and b -> a (3,), unit."""
    overlap, distance, between = overlaps(a, b)
    i, j = np.unravel_index(int(overlap.argmax()), overlap.shape)
    gap = float(distance[i, j])
    way: Floats = between[i, j] / gap if gap > 1e-9 else np.array([1.0, 0.0, 0.0])
    return float(overlap[i, j]), way
