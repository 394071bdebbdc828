"""Plants in pots."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.surfaces.assets import Assets, Vector
from sim.surfaces.shapes import ellipsoid, revolved
from sim.surroundings.on_walls import colour_of
from sim.vectors import about_y, about_z


def add_plant(
    assets: Assets, body: Any, name: str, at_m: Vector, height_m: float, castshadow: bool
) -> None:
    """Add a plant, its pot's foot at at_m (3,), with leaves on stems or out of the pot."""
    rng = assets.rng(f"plant:{name}")
    pot, radius = 0.30 * height_m, float(rng.uniform(0.15, 0.20)) * height_m
    assets.plain(f"{name}:pot", colour_of(rng, 0.15, 0.85, 0.6), specular=0.12, shininess=0.3)
    assets.plain(f"{name}:soil", (0.13, 0.10, 0.08))
    green = (
        np.array([0.16, 0.34, 0.13]) * rng.uniform(0.7, 1.5)
        + np.array([0.10, 0.0, 0.02]) * rng.random()
    )
    for shade in range(3):
        r, g, b = (green * (0.78 + 0.22 * shade)).tolist()
        assets.plain(f"{name}:leaf:{shade}", (r, g, b), specular=0.10, shininess=0.3)
    side = [[0.72, 0], [0.78, 0.05], [1.0, 0.9], [1.06, 0.92], [1.06, 1.0], [0.94, 1.0]]
    profile = np.array([[0, 0], *side, [0.92, 0.85], [0, 0.85]]) * [radius, pot]
    assets.add(
        body,
        f"{name}:pot",
        revolved(profile, 22),
        f"{name}:pot",
        0,
        pos=at_m,
        castshadow=castshadow,
    )
    soil = (at_m[0], at_m[1], at_m[2] + 0.86 * pot)
    assets.ellipsoid(
        body, f"{name}:soil", soil, (0.9 * radius, 0.9 * radius, 0.05 * pot), f"{name}:soil"
    )
    upright = rng.random() < 0.35
    long = (0.55 if upright else 0.30) * height_m
    half = np.array([long / 2, (0.10 if upright else 0.22) * long, 0.012 * long])
    leaf = ellipsoid(half, sides=10, rings=6)
    count = 12 if upright else int(rng.integers(18, 28))
    for i in range(count):
        turn = 2.399963 * i + float(rng.uniform(-0.3, 0.3))  # the golden angle, as plants have it
        share = (i + 0.5) / count
        rise = (
            float(rng.uniform(1.0, 1.45))
            if upright
            else 1.15 - 1.35 * share + float(rng.normal(0, 0.12))
        )
        base = (
            at_m[2]
            + pot * (0.85 if upright else 0.9)
            + (0.0 if upright else 0.62 * share * (height_m - pot))
        )
        way = about_z(turn) @ about_y(-rise)
        start = (
            np.array([at_m[0], at_m[1], base])
            + about_z(turn)[:, 0] * (0.3 if upright else 0.12) * radius
        )
        if not upright:
            start = start + way[:, 0] * 0.25 * long
        middle = start + way[:, 0] * long / 2
        x, y, z = middle.tolist()
        quat = assets.quaternion(way)
        assets.add(
            body, f"{name}:leaf:{i}", leaf, f"{name}:leaf:{int(rng.integers(3))}", 0,
            pos=(x, y, z), quat=quat, mesh=f"{name}:leaf", castshadow=castshadow,
        )  # fmt: skip
        if not upright:
            foot = (at_m[0], at_m[1], at_m[2] + 0.85 * pot)
            tip = (start + way[:, 0] * 0.02).tolist()
            assets.capsule(
                body,
                f"{name}:stem:{i}",
                (foot, tip),
                0.008 * height_m,
                f"{name}:leaf:0",
                castshadow=False,
            )
