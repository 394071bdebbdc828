"""Objects of a scene as shapes: in the way of the person, or of the colour of skin."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise

import numpy as np

from pjpdaf.arrays import Floats
from sim.pose import Transform
from sim.silhouettes.pose_track import Places, PoseTrack
from sim.silhouettes.shapes import BARE, CLOTHED, STANDING, Bars, Hull, bars_of
from sim.specs import ObjectSpec, SceneSpec

_IGNORED = ("picture", "chair")  # behind the person
_SCREEN = "shadow_screen"  # behind the cameras
_PIECE_M = 0.08  # tall and long things are ordered by depth in pieces
_MOVED_M = 0.01  # further from where it was learnt: foreground
_FLAT = 0.25  # of its breadth, the thickness of a flat object at most
_TURN = np.linspace(0.0, 2.0 * np.pi, 11)[:-1]
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)])


def thing_shapes(
    track: PoseTrack, scene: SceneSpec, learnt: Mapping[str, Transform]
) -> tuple[list[Bars], list[Hull]]:
    """Bars and hulls of the scene's objects.

    learnt: where an object was while the background was learnt, if not at the first moment.
    """
    bars: list[Bars] = []
    hulls: list[Hull] = []
    for spec in scene.room.objects:
        if spec.kind in _IGNORED or spec.name == _SCREEN:
            continue
        places = track.objects[spec.name]
        if spec.kind == "balloon":
            bars.append(_balloon(spec, places))
        elif spec.kind == "arm":
            bars += _other_arm(spec, places)
        else:
            paint = _paint(places, learnt.get(spec.name))
            axis = _flat_axis(spec)
            normals = None if axis is None else places.rotations[:, :, axis]
            hulls += [
                Hull(places.moved(piece), paint, normals=normals)
                for piece in _pieces(spec.kind, spec.size_m)
            ]
    return bars, hulls


def _flat_axis(spec: ObjectSpec) -> int | None:
    """The axis across a flat or thin object, None for others."""
    if spec.kind == "rod":
        return 2
    thin, middle, _ = sorted(spec.size_m)
    return spec.size_m.index(thin) if thin < _FLAT * middle else None


def _paint(places: Places, learnt: Transform | None) -> int:
    """STANDING for what never leaves where the background has it, else CLOTHED (foreground)."""
    first = places.positions_m[0] if learnt is None else learnt.position_m
    moved = np.abs(places.positions_m - first).max()
    return CLOTHED if moved > _MOVED_M else STANDING


@lru_cache(maxsize=64)
def _pieces(kind: str, size_m: tuple[float, float, float]) -> tuple[Floats, ...]:
    """Convex pieces of an object, its own frame: origin in the middle of its base."""
    sx, sy, sz = size_m
    if kind in ("post", "can", "cup"):
        radius = min(sx, sy) / 2 * (0.82 if kind == "cup" else 1.0)
        ring = radius * _CIRCLE
        return tuple(
            np.concatenate([np.column_stack([ring, np.full(len(ring), z)]) for z in (low, high)])
            for low, high in pairwise(_cuts(0.0, sz))
        )
    if kind == "ball":
        tilted = np.array([[c * d, s * d, h] for d, h in _BALL for c, s in _CIRCLE])
        return (tilted * np.array(size_m) / 2 + np.array([0.0, 0.0, sz / 2]),)
    if sx >= sy:
        return tuple(_box((low, -sy / 2), (high, sy / 2), sz) for low, high in _pairs(sx))
    return tuple(_box((-sx / 2, low), (sx / 2, high), sz) for low, high in _pairs(sy))


_BALL = ((0.5, -0.866), (1.0, 0.0), (0.866, 0.5), (0.866, -0.5), (0.5, 0.866), (0.01, 1.0))


def _pairs(extent_m: float) -> list[tuple[float, float]]:
    return list(pairwise(_cuts(-extent_m / 2, extent_m / 2)))


def _cuts(low: float, high: float) -> list[float]:
    count = max(1, round((high - low) / _PIECE_M))
    return [low + (high - low) * i / count for i in range(count + 1)]


def _box(low: tuple[float, float], high: tuple[float, float], height_m: float) -> Floats:
    return np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (0.0, height_m)]
    )


def _balloon(spec: ObjectSpec, places: Places) -> Bars:
    sx, sy, sz = spec.size_m
    radius = (sx + sy) / 4
    middle = np.array([[0.0, 0.0, radius], [0.0, 0.0, max(sz - radius, radius + 1e-3)]])
    ends = places.moved(middle)
    return bars_of(ends[:, :1], ends[:, 1:], np.full((1, 2), radius), BARE)


def _other_arm(spec: ObjectSpec, places: Places) -> list[Bars]:
    """Somebody else's bare forearm and hand, at +x, in a sleeve at -x."""
    long, thick, _ = spec.size_m
    k = min(thick / 0.075, long / 0.40)
    wrist = long / 2 - 0.185 * k
    z = 0.0375 * k
    x = np.array([-0.5 * long, -0.2 * long, wrist, long / 2 - 0.03 * k])
    points = places.moved(np.column_stack([x, np.zeros(4), np.full(4, z)]))
    radii = k * np.array([[0.043, 0.042], [0.037, 0.0225], [0.03, 0.036]])
    sleeve = bars_of(points[:, :1], points[:, 1:2], radii[:1], CLOTHED)
    return [sleeve, bars_of(points[:, 1:3], points[:, 2:4], radii[1:], BARE)]
