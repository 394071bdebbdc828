"""Clutter on the table, out of the way of a planned motion, and a second person behind."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from pjpdaf.arrays import Floats
from sim.randomness import generator
from sim.specs import RGB, ObjectSpec, RoomSpec, Surroundings
from sim.surroundings.on_walls import colour_of
from sim.surroundings.seat_and_table import corner_axes, far_corner

BYSTANDER = "second_person"
_TRIES = 14  # places that are tried for each thing
_HAND_M = 0.20  # from a palm to a thing's outline: a hand, and its wrist
_ARM_M = 0.11  # likewise from the forearm's line
_SIGHT_M = 0.09  # of a line of sight from a camera to a target
_EDGE_M = 0.02
# Kind -> least and greatest extent along x, y, z [m].
_SIZES: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "book": ((0.14, 0.20, 0.012), (0.19, 0.26, 0.05)),
    "cup": ((0.09, 0.09, 0.085), (0.11, 0.11, 0.11)),
    "can": ((0.06, 0.06, 0.11), (0.07, 0.07, 0.16)),
    "box": ((0.08, 0.10, 0.05), (0.2, 0.24, 0.13)),
    "block": ((0.05, 0.12, 0.04), (0.10, 0.22, 0.09)),
    "phone": ((0.072, 0.145, 0.008), (0.078, 0.16, 0.010)),
    "plant": ((0.14, 0.14, 0.20), (0.2, 0.2, 0.34)),
    "bottle": ((0.065, 0.065, 0.20), (0.085, 0.085, 0.30)),
    "papers": ((0.22, 0.30, 0.003), (0.23, 0.31, 0.012)),
    "desk_lamp": ((0.18, 0.18, 0.32), (0.24, 0.24, 0.44)),
    "laptop": ((0.22, 0.31, 0.22), (0.25, 0.35, 0.25)),
}
_KINDS = tuple(_SIZES)


def outside_corner(room: RoomSpec, x_m: float, y_m: float) -> float:
    """How far [m] a point is outside the drawn table; negative inside. Corners may be round."""
    around = room.surroundings
    half_w, depth = room.table_width_m / 2, room.table_depth_m
    x = x_m - room.table_near_x_m
    outside = max(-x, x - depth, abs(y_m) - half_w)
    if around is None or around.table_shape == "straight":
        return outside
    half = np.array([depth / 2, half_w])
    rx, ry = corner_axes(half, far_corner(around.table_shape, half))
    u, v = x - (depth - rx), abs(y_m) - (half_w - ry)
    if u > 0 and v > 0:
        return max(outside, (math.hypot(u / rx, v / ry) - 1.0) * min(rx, ry))
    return outside


def clutter_of(
    room: RoomSpec, palms_m: Floats, shoulders_m: Floats, heads_m: Floats, cameras_m: Floats
) -> tuple[ObjectSpec, ...]:
    """Things on the table that neither stand in the way of the arms nor hide them.

    palms_m, shoulders_m (F, 2, 3), heads_m (F, 3): of a planned motion; cameras_m (2, 3):
    centres. The room's own objects keep clear of them too. Empty for a room without surroundings.
    """
    around = room.surroundings
    if around is None or not (around.clutter or around.screen == "table"):
        return ()
    rng = generator(around.arrangement, "clutter")
    kinds = ["monitor"] if around.screen == "table" else []
    kinds += [_KINDS[int(i)] for i in rng.integers(len(_KINDS), size=around.clutter)]
    placed: list[ObjectSpec] = []
    for number, kind in enumerate(kinds):
        size = _size(rng, kind)
        rgb = colour_of(rng, 0.06, 0.85, 0.35)
        for _ in range(_TRIES):
            spec = ObjectSpec(
                f"clutter_{number}_{kind}",
                kind,
                size,
                (0.10, 0.10, 0.11) if kind in ("monitor", "laptop", "phone") else rgb,
                (
                    room.table_near_x_m + float(rng.uniform(0.0, 1.0)) * room.table_depth_m,
                    float(rng.uniform(-0.5, 0.5)) * room.table_width_m,
                ),
                yaw_rad=_yaw(rng, kind),
            )
            if _fits(room, spec, (*room.objects, *placed)) and _free(
                room, spec, palms_m, shoulders_m, heads_m, cameras_m
            ):
                placed.append(spec)
                break
    return tuple(placed)


def _size(rng: np.random.Generator, kind: str) -> tuple[float, float, float]:
    if kind == "monitor":
        breadth = float(rng.uniform(0.44, 0.58))
        return (0.2, breadth, 0.62 * breadth + 0.12)
    low, high = np.array(_SIZES[kind])
    x, y, z = (low + rng.random(3) * (high - low)).tolist()
    if kind in ("cup", "can", "bottle", "plant", "desk_lamp"):
        y = x
    return (x, y, z)


def _yaw(rng: np.random.Generator, kind: str) -> float:
    """A turn [rad]; screens turn their faces to the person, who may have pushed them aside."""
    if kind in ("monitor", "laptop"):
        return math.pi + float(rng.uniform(-0.5, 0.5))
    return float(rng.uniform(-math.pi, math.pi))


def _radius(spec: ObjectSpec) -> float:
    return 0.5 * math.hypot(*spec.size_m[:2])


def _fits(room: RoomSpec, spec: ObjectSpec, others: Iterable[ObjectSpec]) -> bool:
    """Whether a thing lies wholly on the table and clear of other things."""
    x, y = spec.position_xy_m
    turn = spec.yaw_rad
    c, s = math.cos(turn), math.sin(turn)
    for sx in (-0.5, 0.5):
        for sy in (-0.5, 0.5):
            dx, dy = sx * spec.size_m[0], sy * spec.size_m[1]
            corner = x + c * dx - s * dy, y + s * dx + c * dy
            if outside_corner(room, *corner) > -_EDGE_M:
                return False
    for other in others:
        gap = math.hypot(x - other.position_xy_m[0], y - other.position_xy_m[1])
        if gap < _radius(spec) + _radius(other) + 0.01:
            return False
    return True


def _free(
    room: RoomSpec,
    spec: ObjectSpec,
    palms_m: Floats,
    shoulders_m: Floats,
    heads_m: Floats,
    cameras_m: Floats,
) -> bool:
    """Whether a thing, as an upright cylinder, is clear of the arms and of what is filmed."""
    centre, radius = np.array(spec.position_xy_m), _radius(spec)
    top = room.table_height_m + spec.size_m[2]
    starts, ends = shoulders_m.reshape(-1, 3), palms_m.reshape(-1, 3)
    near = np.linalg.norm(ends[:, :2] - centre, axis=1) < radius + _HAND_M
    if (near & (ends[:, 2] < top + _HAND_M)).any():
        return False
    if _crosses(starts, ends, centre, radius + _ARM_M, top + _ARM_M):
        return False
    filmed = np.concatenate([ends, heads_m])
    return not any(
        _crosses(
            np.broadcast_to(camera, filmed.shape), filmed, centre, radius + _SIGHT_M, top + _SIGHT_M
        )
        for camera in cameras_m
    )


def _crosses(
    starts_m: Floats, ends_m: Floats, centre_m: Floats, radius_m: float, top_m: float
) -> bool:
    """Whether a segment (n, 3) enters a cylinder that stands on the floor."""
    for share in np.linspace(0.0, 1.0, 17):
        points = starts_m + share * (ends_m - starts_m)
        inside = np.linalg.norm(points[:, :2] - centre_m, axis=1) < radius_m
        if (inside & (points[:, 2] < top_m)).any():
            return True
    return False


def bystander_of(around: Surroundings) -> ObjectSpec | None:
    """The second person of a room, who stands behind the first, to one side; None without one."""
    if around.bystander == "none":
        return None
    rng = generator(around.arrangement, "bystander")
    side = 1.0 if rng.random() < 0.5 else -1.0
    skins: tuple[RGB, ...] = (
        (0.86, 0.62, 0.50),
        (0.80, 0.56, 0.43),
        (0.66, 0.46, 0.34),
        (0.48, 0.31, 0.23),
        (0.33, 0.21, 0.16),
    )
    far = around.depth_m - 0.45
    x = -float(rng.uniform(min(0.75, far), far))
    y = side * float(rng.uniform(0.55, min(1.25, around.half_width_m - 0.4)))
    return ObjectSpec(
        BYSTANDER,
        "bystander",
        (0.36, 0.50, float(rng.uniform(1.55, 1.85))),
        skins[int(rng.integers(len(skins)))],
        (x, y),
        yaw_rad=-0.5 * side * float(rng.uniform(0.0, 1.0)),
        base_m=0.0,
    )
