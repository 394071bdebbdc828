"""Things: on the table, in a hand, in the way. Each kind draws itself into a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sim import textures
from sim.assets import Assets, turned
from sim.body import ROOM, limb_ring
from sim.shapes import revolved
from sim.specs import ObjectSpec, RoomSpec


def add_object(assets: Assets, room: RoomSpec, thing: ObjectSpec) -> None:
    """A body of its own that can be posed. Raises ValueError for an unknown kind."""
    base_m = room.table_height_m if thing.base_m is None else thing.base_m
    body = assets.spec.worldbody.add_body(
        name=f"object:{thing.name}",
        mocap=True,
        pos=[*thing.position_xy_m, base_m],
        quat=list(turned(thing.yaw_rad)),
    )
    if thing.kind not in KINDS:
        known = tuple(KINDS)
        raise ValueError(f"object {thing.name!r}: kind must be one of {known}, got {thing.kind!r}")
    name = f"object:{thing.name}"
    KINDS[thing.kind](assets, body, name, thing)


def _glossy(assets: Assets, name: str, thing: ObjectSpec) -> None:
    assets.plain(name, thing.rgb, specular=0.25, shininess=0.4)


def _can(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    _glossy(assets, name, thing)
    r, h = min(thing.size_m[:2]) / 2, thing.size_m[2]
    can = revolved(
        np.array(
            [
                [0, 0.003],
                [0.8 * r, 0.003],
                [0.86 * r, 0],
                [r, 0.05 * h],
                [r, 0.5 * h],
                [r, 0.92 * h],
                [0.87 * r, 0.985 * h],
                [0.8 * r, 0.985 * h],
            ]
        ),
        28,
    )
    assets.plain(f"{name}:lid", (0.70, 0.71, 0.73), specular=0.5, shininess=0.6)
    label = textures.shade(thing.rgb, np.ones((64, 128)))
    light = np.clip(0.55 + 0.45 * np.array(thing.rgb), 0, 1)
    label[26:38] = textures.to_bytes(light)
    label[20:23] = label[41:44] = textures.to_bytes(np.array([0.75, 0.76, 0.78]))
    assets.painted(f"{name}:label", label, specular=0.3, shininess=0.5)
    assets.add(body, name, can, f"{name}:label", ROOM)
    lid = revolved(
        np.array(
            [
                [0, 0.97 * h],
                [0.84 * r, 0.97 * h],
                [0.86 * r, h],
                [0.80 * r, h],
                [0.78 * r, 0.975 * h],
                [0, 0.975 * h],
            ]
        ),
        28,
    )
    assets.add(body, f"{name}:lid", lid, f"{name}:lid", ROOM)


def _cup(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    _glossy(assets, name, thing)
    r, h = min(thing.size_m[:2]) / 2 * 0.82, thing.size_m[2]
    wall = 0.08 * r
    cup = revolved(
        np.array(
            [
                [0, 0],
                [0.78 * r, 0],
                [0.88 * r, 0.08 * h],
                [r, 0.6 * h],
                [r, h],
                [r - wall, h],
                [r - 1.4 * wall, 0.6 * h],
                [0.78 * r, 0.12 * h],
                [0, 0.10 * h],
            ]
        ),
        28,
    )
    assets.add(body, name, cup, name, ROOM)
    ring = limb_ring(0.30 * h, 0.055 * h)
    assets.add(
        body,
        f"{name}:handle",
        ring,
        name,
        ROOM,
        pos=(0.0, r + 0.06 * h, 0.52 * h),
        quat=(0.5, 0.5, 0.5, 0.5),
    )


def _box(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    _glossy(assets, name, thing)
    sx, sy, sz = (s / 2 for s in thing.size_m)
    assets.box(body, name, (0, 0, sz), (sx, sy, sz), name)


def _ball(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    _glossy(assets, name, thing)
    sx, sy, sz = (s / 2 for s in thing.size_m)
    assets.ellipsoid(body, name, (0, 0, sz), (sx, sy, sz), name)


def _book(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    _glossy(assets, name, thing)
    sx, sy, sz = (s / 2 for s in thing.size_m)
    cover = min(0.0025, sz / 4)
    assets.plain(f"{name}:pages", (0.82, 0.82, 0.80))
    assets.box(
        body, f"{name}:pages", (0.004, 0, sz), (sx - 0.006, sy - 0.004, sz - cover), f"{name}:pages"
    )
    assets.box(body, name, (0, 0, cover / 2), (sx, sy, cover / 2), name)
    assets.box(body, f"{name}:upper", (0, 0, 2 * sz - cover / 2), (sx, sy, cover / 2), name)
    assets.box(body, f"{name}:spine", (-sx + cover / 2, 0, sz), (cover / 2, sy, sz), name)


def _post(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    """A round post on a foot: size x, y of the post, z its height."""
    _glossy(assets, name, thing)
    r, h = min(thing.size_m[:2]) / 2, thing.size_m[2]
    foot = min(2.2 * r, r + 0.05)
    profile = [[0, 0], [foot, 0], [foot, 0.008], [r, 0.012], [r, h], [0, h]]
    assets.add(body, name, revolved(np.array(profile), 32), name, ROOM)


def _rod(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    """A round-ended rod along its x axis: size x its length, y its thickness."""
    _glossy(assets, name, thing)
    half, r = thing.size_m[0] / 2, thing.size_m[1] / 2
    assets.capsule(body, name, ((-half + r, 0, r), (half - r, 0, r)), r, name)


def _block(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    """A block of wood with grain."""
    assets.painted(name, textures.wood(assets.rng(name), thing.rgb, planks=1), specular=0.05)
    sx, sy, sz = (s / 2 for s in thing.size_m)
    assets.box(body, name, (0, 0, sz), (sx, sy, sz), name)


def _sheet(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    """A cloth, card or board: a flat block with a woven surface."""
    assets.cloth(name, thing.rgb)
    sx, sy, sz = (s / 2 for s in thing.size_m)
    assets.box(body, name, (0, 0, sz), (sx, sy, sz), name)


def _phone(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    """A telephone lying on its back, screen up: size x its breadth, y its length, z thickness."""
    _glossy(assets, name, thing)
    sx, sy, sz = (s / 2 for s in thing.size_m)
    assets.plain(f"{name}:screen", (0.03, 0.03, 0.04), specular=0.5, shininess=0.8)
    assets.box(body, name, (0, 0, sz), (sx, sy, sz), name)
    assets.box(
        body, f"{name}:screen", (0, 0, 2 * sz), (0.92 * sx, 0.95 * sy, 0.0004), f"{name}:screen"
    )


def _arm(assets: Assets, body: Any, name: str, thing: ObjectSpec) -> None:
    """Somebody else's bare forearm with a closed hand at +x: size x its length, y thickness."""
    assets.plain(name, thing.rgb, specular=0.05, shininess=0.2)
    long, r = thing.size_m[0], thing.size_m[1] / 2
    ends = ((-long / 2, 0, r), (long / 2 - 2.2 * r, 0, r))
    assets.capsule(body, name, ends, 0.8 * r, name)
    fist = (1.35 * r, 1.1 * r, r)
    assets.ellipsoid(body, f"{name}:fist", (long / 2 - 1.35 * r, 0, r), fist, name)


Draw = Callable[[Assets, Any, str, ObjectSpec], None]

KINDS: Mapping[str, Draw] = {
    "can": _can,
    "cup": _cup,
    "box": _box,
    "ball": _ball,
    "book": _book,
    "post": _post,
    "rod": _rod,
    "block": _block,
    "sheet": _sheet,
    "phone": _phone,
    "arm": _arm,
}
