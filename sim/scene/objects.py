"""Objects on the table, in a hand, in the way. Each kind has a function that draws it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.anatomy import Anatomy
from sim.person.geoms import ROOM
from sim.person.hand import fingers, palm_surface, placed_segments
from sim.specs import RGB, ObjectSpec, RoomSpec
from sim.surfaces import textures
from sim.surfaces.assets import Assets, check_word, turned
from sim.surfaces.blocks import block
from sim.surfaces.shapes import Surface, limb, limb_ring, revolved
from sim.surroundings.shell import FACING
from sim.surroundings.things import DRAW, Draw


def add_object(assets: Assets, room: RoomSpec, spec: ObjectSpec) -> None:
    """A body of its own that can be posed. Raises ValueError for an unknown kind."""
    base_m = room.table_height_m if spec.base_m is None else spec.base_m
    body = assets.spec.worldbody.add_body(
        name=f"object:{spec.name}",
        mocap=True,
        pos=[*spec.position_xy_m, base_m],
        quat=list(turned(spec.yaw_rad)),
    )
    check_word(f"object {spec.name!r}: kind", spec.kind, KINDS)
    name = f"object:{spec.name}"
    KINDS[spec.kind](assets, body, name, spec)


def _glossy(assets: Assets, name: str, spec: ObjectSpec) -> None:
    assets.plain(name, spec.rgb, specular=0.25, shininess=0.4)


def _can(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    _glossy(assets, name, spec)
    r, h = min(spec.size_m[:2]) / 2, spec.size_m[2]
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
    label = textures.shade(spec.rgb, np.ones((64, 128)))
    light = np.clip(0.55 + 0.45 * np.array(spec.rgb), 0, 1)
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


def _cup(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    _glossy(assets, name, spec)
    r, h = min(spec.size_m[:2]) / 2 * 0.82, spec.size_m[2]
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


def _box(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A box of sheet metal or plastic."""
    _glossy(assets, name, spec)
    assets.add(body, name, block(spec.size_m, edge_m=0.005), name, ROOM)


def _ball(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    _glossy(assets, name, spec)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 17)
    sphere = revolved(np.column_stack([np.cos(turn), 1 + np.sin(turn)]), 28)
    _round(assets, body, name, _stretched(sphere, spec.size_m), spec)


def _balloon(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A balloon of this size on a string that hangs down from it."""
    assets.plain(name, spec.rgb, specular=0.12, shininess=0.3)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 21)
    pear = np.where(turn < 0, 1 - 0.16 * np.sin(turn) ** 2, 1.0)
    profile = np.column_stack([np.cos(turn) * pear, 1 + np.sin(turn)])
    _round(assets, body, name, _stretched(revolved(profile, 28), spec.size_m), spec)
    knot = 0.05 * spec.size_m[2]
    tip = revolved(np.array([[0, -knot], [0.7 * knot, -knot], [0.2 * knot, 0], [0, knot]]), 12)
    assets.add(body, f"{name}:knot", tip, name, ROOM)
    assets.plain(f"{name}:string", (0.55, 0.56, 0.58))
    assets.capsule(body, f"{name}:string", ((0, 0, -knot), (0, 0, -0.5)), 0.0015, f"{name}:string")


def _round(assets: Assets, body: Any, name: str, surface: Surface, spec: ObjectSpec) -> None:
    """Add a round object; a smaller core casts its shadow, so that none speckles the object."""
    assets.add(body, name, surface, name, ROOM, castshadow=False)
    sx, sy, sz = (0.42 * s for s in spec.size_m)
    assets.ellipsoid(body, f"{name}:core", (0, 0, 0.5 * spec.size_m[2]), (sx, sy, sz), name)


def _stretched(unit: Surface, size_m: tuple[float, float, float]) -> Surface:
    """A surface within a ball of radius 1 on z = 0, brought to this extent."""
    half = np.array(size_m) / 2
    normals = unit.normals / half
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Surface(unit.vertices_m * half, normals, unit.uv, unit.faces)


def _book(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A bound book lying down, its spine at -x."""
    sx, sy, sz = spec.size_m
    cover = min(0.003, sz / 4)
    assets.plain(name, spec.rgb, specular=0.12, shininess=0.3)
    assets.plain(f"{name}:pages", (0.80, 0.81, 0.80))
    assets.plain(f"{name}:title", _paler(spec))
    pages = block((sx - 0.008, sy - 0.008, sz - 1.2 * cover), edge_m=0.0008)
    assets.add(body, f"{name}:pages", pages, f"{name}:pages", ROOM, pos=(-0.002, 0, 0.6 * cover))
    board = block((sx, sy, cover), edge_m=0.001, corner_m=0.002)
    assets.add(body, name, board, name, ROOM)
    upper = (0.0, 0.0, sz - cover)
    assets.add(body, f"{name}:upper", board, name, ROOM, pos=upper, mesh=name)
    spine = block((1.6 * cover, sy, sz), edge_m=0.7 * cover)
    assets.add(body, f"{name}:spine", spine, name, ROOM, pos=(-sx / 2 + 0.8 * cover, 0, 0))
    label = (0.16 * sx, 0.30 * sy, 0.0003)
    assets.box(body, f"{name}:title", (0.1 * sx, 0, sz), label, f"{name}:title", castshadow=False)


def _paler(spec: ObjectSpec) -> RGB:
    red, green, blue = (0.55 + 0.45 * c for c in spec.rgb)
    return red, green, blue


def _post(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A round post on a foot: size x, y of the post, z its height."""
    _glossy(assets, name, spec)
    r, h = min(spec.size_m[:2]) / 2, spec.size_m[2]
    foot, up = min(2.2 * r, r + 0.05), min(1.0, h / 0.08)
    profile = [
        [0, 0],
        [foot, 0],
        [foot, 0.006 * up],
        [0.96 * foot, 0.009 * up],
        [0.55 * foot + 0.45 * r, 0.014 * up],
        [1.05 * r, 0.022 * up],
        [r, 0.030 * up],
        [r, h - 0.3 * r * up],
        [0.92 * r, h - 0.08 * r * up],
        [0.72 * r, h],
        [0, h],
    ]
    assets.add(body, name, revolved(np.array(profile), 28), name, ROOM)


def _rod(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A tool's shaft along its x axis with a thicker grip at -x: size x its length, y thickness."""
    _glossy(assets, name, spec)
    darker = (0.6 * spec.rgb[0], 0.6 * spec.rgb[1], 0.6 * spec.rgb[2])
    assets.plain(f"{name}:grip", darker, specular=0.05)
    long, r = spec.size_m[0], min(spec.size_m[1], 0.8 * spec.size_m[0]) / 2
    shaft = limb(long - 2 * r, np.array([0.8, 0.8, 0.8]) * r, sides=16, rings=3)
    assets.add(body, name, shaft, name, ROOM, pos=(-long / 2 + 1.2 * r, 0, r))
    swell = np.array([0.94, 1.0, 0.93, 1.0, 0.90]) * r
    grip = limb(0.38 * (long - 2 * r), swell, sides=16, rings=9, far_cap=0.3)
    assets.add(body, f"{name}:grip", grip, f"{name}:grip", ROOM, pos=(-long / 2 + r, 0, r))


def _block(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A block of wood with grain."""
    texture = assets.texture(name, textures.wood, spec.rgb, planks=1, size=256)
    assets.painted(name, texture, specular=0.06)
    assets.add(body, name, block(spec.size_m, edge_m=0.004), name, ROOM)


def _sheet(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A cloth, card or board with a woven surface, lying or standing: its thinnest side says."""
    assets.cloth(name, spec.rgb)
    assets.add(body, name, block(spec.size_m, edge_m=0.0025), name, ROOM)


def _phone(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A telephone lying on its back, screen up: size x its breadth, y its length, z thickness."""
    _glossy(assets, name, spec)
    sx, sy, sz = spec.size_m
    corner = 0.11 * min(sx, sy)
    assets.add(body, name, block(spec.size_m, 0.3 * sz, corner), name, ROOM)
    assets.plain(f"{name}:screen", (0.03, 0.03, 0.04), specular=0.5, shininess=0.8)
    screen = block((0.93 * sx, 0.96 * sy, 0.0006), 0.0002, 0.8 * corner)
    assets.add(body, f"{name}:screen", screen, f"{name}:screen", ROOM, pos=(0, 0, sz - 0.0002))


def _picture(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A framed painting of dunes that faces +x: size x its depth, y breadth, z height."""
    sx, sy, sz = spec.size_m
    assets.plain(f"{name}:frame", spec.rgb, specular=0.15)
    assets.painted(name, assets.texture(name, textures.painting, warm=True), specular=0.0)
    assets.add(body, f"{name}:frame", block(spec.size_m), f"{name}:frame", ROOM)
    rim = 0.07 * min(sy, sz)
    half = (sy / 2 - rim, sz / 2 - rim)
    assets.plane(body, name, (sx / 2 + 0.001, 0, sz / 2), half, FACING, name)


def _chair(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A wooden chair with its back at -x: size x depth, y breadth, z height."""
    sx, sy, sz = spec.size_m
    texture = assets.texture(name, textures.wood, spec.rgb, planks=1, size=128)
    assets.painted(name, texture, specular=0.08)
    bar, seat = 0.018, 0.5 * sz
    assets.add(body, name, block((sx, sy, 0.03), 0.008, 0.03), name, ROOM, pos=(0, 0, seat))
    x, y = sx / 2 - 1.5 * bar, sy / 2 - 1.5 * bar
    for side, at in (("right", -y), ("left", y)):
        ends = ((x, at, 0.0), (x, at, seat))
        assets.capsule(body, f"{name}:front:{side}", ends, bar, name)
        ends = ((-x, at, 0.0), (-x - 0.05, at, sz))
        assets.capsule(body, f"{name}:back:{side}", ends, bar, name)
    for i, share in enumerate((0.66, 0.80, 0.94)):
        at_x = -x - 0.05 * share
        assets.box(body, f"{name}:slat:{i}", (at_x, 0, share * sz), (0.008, y, 0.03 * sz), name)


_ARM_M = 0.40  # an average arm from fingertips to the middle of the forearm


def _arm(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """Somebody else's bare forearm, palm down, hand at +x, in a sleeve at -x.

    size x: its length; y: thickness of the forearm, from which the hand follows.
    """
    assets.plain(name, spec.rgb, specular=0.05, shininess=0.2)
    assets.cloth(f"{name}:sleeve", (0.30, 0.33, 0.36))
    long = spec.size_m[0]
    k = min(spec.size_m[1] / 0.075, long / _ARM_M)
    anatomy = Anatomy.of(1.72 * k)
    z = 0.0375 * k
    palm_x = long / 2 - 0.108 * k
    wrist_x = palm_x - anatomy.wrist_to_palm_m
    fore = wrist_x + long / 2
    radii = np.array([0.0375, 0.0375, 0.0370, 0.0300, 0.0225]) * k
    surface = limb(fore, radii, sides=20, rings=10, far_cap=0.15)
    assets.add(body, name, surface, name, ROOM, pos=(-long / 2, 0, z))
    sleeve = limb(0.30 * fore, np.array([0.043, 0.043, 0.042]) * k, 20, 4, far_cap=0.1)
    assets.add(body, f"{name}:sleeve", sleeve, f"{name}:sleeve", ROOM, pos=(-long / 2, 0, z))
    at_palm = np.array([palm_x, 0.0, z])
    palm = palm_surface(anatomy)
    assets.add(body, f"{name}:palm", palm, name, ROOM, pos=(palm_x, 0, z), castshadow=False)
    core = (0.05 * k, 0.03 * k, 0.010 * k)
    assets.ellipsoid(body, f"{name}:core", (palm_x - 0.01 * k, 0, z), core, name)
    for finger in fingers(anatomy):
        segments = placed_segments(finger, 0.12, finger.base_m, finger.rotation)
        for i, (surface, joint, turn, tip) in enumerate(segments):
            x, y, up = (joint + at_palm).tolist()
            assets.add(
                body,
                f"{name}:{finger.name}{i}",
                surface,
                name,
                ROOM,
                pos=(x, y, up),
                quat=assets.quaternion(turn),
                castshadow=False,
            )
            ends = (joint + at_palm, tip + at_palm)
            core_r = 0.6 * finger.radii_m[i + 1]
            assets.capsule(body, f"{name}:core:{finger.name}{i}", ends, core_r, name)


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
    "balloon": _balloon,
    "picture": _picture,
    "chair": _chair,
    **DRAW,
}
