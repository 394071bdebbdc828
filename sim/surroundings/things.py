"""Things of a table's clutter, each drawn within its ObjectSpec's size. `DRAW` has them by kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sim.specs import ObjectSpec
from sim.surfaces.assets import Assets
from sim.surfaces.blocks import block
from sim.surfaces.picture_textures import screen
from sim.surfaces.shapes import revolved
from sim.surroundings.people import add_bystander
from sim.surroundings.plants import add_plant
from sim.surroundings.shell import FACING
from sim.vectors import about_y


def _plant(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    add_plant(assets, body, name, (0.0, 0.0, 0.0), spec.size_m[2], True)


def _bottle(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A bottle with a label and a cap."""
    r, h = min(spec.size_m[:2]) / 2, spec.size_m[2]
    assets.plain(name, spec.rgb, specular=0.45, shininess=0.7)
    assets.plain(f"{name}:label", (0.82, 0.80, 0.74))
    assets.plain(f"{name}:cap", (0.12, 0.12, 0.13), specular=0.2)
    profile = np.array(
        [[0, 0], [0.9, 0], [1, 0.02], [1, 0.58], [0.9, 0.66], [0.40, 0.80], [0.34, 0.93], [0, 0.93]]
    ) * [r, h]  # fmt: skip
    assets.add(body, name, revolved(profile, 24), name, 0)
    band = np.array([[0.8, 0.18], [1.012, 0.18], [1.012, 0.50], [0.8, 0.50]]) * [r, h]
    assets.add(body, f"{name}:label", revolved(band, 24), f"{name}:label", 0, castshadow=False)
    cap = np.array([[0, 0.92], [0.40, 0.92], [0.40, 1.0], [0, 1.0]]) * [r, h]
    assets.add(body, f"{name}:cap", revolved(cap, 16), f"{name}:cap", 0, castshadow=False)


def _laptop(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """An open laptop whose keys and screen face +x: size x its depth, y breadth, z height."""
    sx, sy, sz = spec.size_m
    assets.plain(name, spec.rgb, specular=0.25, shininess=0.4)
    assets.plain(f"{name}:keys", (0.07, 0.07, 0.08))
    assets.add(body, name, block((sx, sy, 0.016), 0.005, 0.012), name, 0)
    keys = (0.30 * sx, 0.44 * sy, 0.0006)
    assets.box(
        body, f"{name}:keys", (-0.10 * sx, 0, 0.0164), keys, f"{name}:keys", castshadow=False
    )
    lid = block((0.010, sy, sz - 0.012), 0.004, 0.008)
    lean = assets.quaternion(about_y(-0.28))
    assets.add(body, f"{name}:lid", lid, name, 0, pos=(-sx / 2, 0, 0.012), quat=lean)
    picture = assets.texture(f"{name}:screen", screen)
    assets.painted(f"{name}:screen", picture, specular=0.1, emission=0.35)
    up, out = about_y(-0.28)[:, 2], about_y(-0.28)[:, 0]
    middle = np.array([-sx / 2, 0.0, 0.012]) + 0.5 * (sz - 0.012) * up + 0.0056 * out
    x, y, z = middle.tolist()
    facing = assets.quaternion(about_y(-0.28) @ np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]))
    half = (sy / 2 - 0.008, (sz - 0.012) / 2 - 0.010)
    assets.plane(body, f"{name}:screen", (x, y, z), half, facing, f"{name}:screen")


def _monitor(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A screen on a foot that shows to +x: size y its breadth, z height over all."""
    _, sy, sz = spec.size_m
    assets.plain(name, spec.rgb, specular=0.2, shininess=0.4)
    foot = block((0.16, 0.22, 0.012), 0.004, 0.03)
    assets.add(body, f"{name}:foot", foot, name, 0)
    assets.capsule(body, f"{name}:neck", ((-0.03, 0, 0.01), (-0.03, 0, 0.5 * sz)), 0.016, name)
    high = 0.62 * sy
    case = block((0.03, sy, high), 0.005, 0.008)
    assets.add(body, name, case, name, 0, pos=(0.0, 0.0, sz - high))
    picture = assets.texture(f"{name}:screen", screen)
    assets.painted(f"{name}:screen", picture, specular=0.1, emission=0.40)
    at = (0.0156, 0.0, sz - high / 2)
    half = (sy / 2 - 0.010, high / 2 - 0.010)
    assets.plane(body, f"{name}:screen", at, half, FACING, f"{name}:screen")


def _desk_lamp(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A lamp with a foot, a stem and a shade."""
    r, h = min(spec.size_m[:2]) / 2, spec.size_m[2]
    assets.plain(name, spec.rgb, specular=0.3, shininess=0.5)
    assets.plain(f"{name}:shade", (0.88, 0.84, 0.75), emission=0.35)
    foot = np.array([[0, 0], [0.75, 0], [0.75, 0.03], [0.1, 0.07], [0.08, 0.7], [0, 0.7]]) * [r, h]
    assets.add(body, name, revolved(foot, 24), name, 0)
    shade = np.array([[1.0, 0.60], [0.62, 1.0], [0.58, 1.0], [0.96, 0.605], [1.0, 0.60]]) * [r, h]
    assets.add(body, f"{name}:shade", revolved(shade, 24), f"{name}:shade", 0)


def _papers(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """Sheets of paper on one another, not quite straight, with lines of text on the first."""
    sx, sy, sz = spec.size_m
    rng = assets.rng(name)
    assets.plain(name, (0.84, 0.84, 0.82))
    assets.plain(f"{name}:ink", (0.35, 0.36, 0.40))
    sheets = 4
    for i in range(sheets):
        x, y, turn = (
            rng.uniform(-0.004, 0.004),
            rng.uniform(-0.004, 0.004),
            rng.uniform(-0.12, 0.12),
        )
        half = (0.46 * sx, 0.46 * sy, sz / sheets / 2)
        place = (float(x), float(y), sz * (i + 0.5) / sheets)
        part = name if i == 0 else f"{name}:{i}"
        assets.box(body, part, place, half, name, yaw_rad=float(turn))
    for i in range(9):
        long = 0.36 * sy * float(rng.uniform(0.4, 1.0))
        at = (0.36 * sx - 0.085 * sx * i, -0.38 * sy + long, sz)
        assets.box(
            body,
            f"{name}:line:{i}",
            at,
            (0.004, long, 0.0004),
            f"{name}:ink",
            yaw_rad=float(turn),
            castshadow=False,
        )


Draw = Callable[[Assets, Any, str, ObjectSpec], None]

DRAW: Mapping[str, Draw] = {
    "plant": _plant,
    "bottle": _bottle,
    "laptop": _laptop,
    "monitor": _monitor,
    "desk_lamp": _desk_lamp,
    "papers": _papers,
    "bystander": add_bystander,
}
