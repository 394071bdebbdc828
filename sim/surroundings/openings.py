"""Doors and windows in a wall."""

from __future__ import annotations

import numpy as np

from sim.specs import RGB
from sim.surfaces.assets import Assets
from sim.surfaces.picture_textures import outdoors
from sim.surfaces.shapes import Surface, closed_grid
from sim.surroundings.on_walls import colour_of
from sim.surroundings.shell import FACING, Wall

DOOR_M, DOOR_HIGH_M = 0.98, 2.06  # breadth with its frame; height
_DAYLIGHT = 0.62  # of a window's view, whatever the light in the room


def add_door(assets: Assets, wall: Wall, y: float, kind: str) -> None:
    """Add a closed door, its frame and handle, middle at y: panelled, glazed or plain."""
    rng, body, tag = assets.rng(f"door:{wall.name}"), wall.body, f"door:{wall.name}"
    light = float(rng.uniform(0.30, 0.80))
    colours: tuple[RGB, ...] = (
        (light, light, light * 0.98),
        (0.40, 0.30, 0.22),
        (0.26 * light, 0.36 * light, 0.40 * light),
    )
    rgb = colours[int(rng.integers(len(colours)))]
    assets.plain(tag, rgb, specular=0.10)
    darker = (0.86 * rgb[0], 0.86 * rgb[1], 0.86 * rgb[2])
    assets.plain(f"{tag}:panel", darker, specular=0.10)
    assets.plain(f"{tag}:metal", (0.55, 0.55, 0.54), specular=0.5, shininess=0.6)
    half = DOOR_M / 2 - 0.07
    for side in (-1, 1):
        jamb = (0.016, y + side * (half + 0.035), DOOR_HIGH_M / 2)
        assets.box(
            body,
            f"{tag}:jamb:{side}",
            jamb,
            (0.016, 0.035, DOOR_HIGH_M / 2),
            "trim",
            castshadow=False,
        )
    lintel = (0.016, y, DOOR_HIGH_M + 0.035)
    assets.box(body, f"{tag}:lintel", lintel, (0.016, half + 0.07, 0.035), "trim", castshadow=False)
    leaf = (0.008, y, DOOR_HIGH_M / 2)
    assets.box(body, tag, leaf, (0.008, half, DOOR_HIGH_M / 2), tag, castshadow=False)
    if kind == "panelled":
        for low, high in ((0.15, 0.92), (1.06, 1.94)):
            for side in (-1, 1):
                at = (0.014, y + side * 0.46 * half, (low + high) / 2)
                size = (0.005, 0.36 * half, (high - low) / 2)
                assets.box(body, f"{tag}:{low}:{side}", at, size, f"{tag}:panel", castshadow=False)
    elif kind == "glazed":
        bright = 0.35 + 0.3 * float(rng.random())
        assets.plain(
            f"{tag}:glass", (bright, bright, bright), specular=0.3, shininess=0.6, emission=0.25
        )
        at, size = (0.017, y, 1.30), (0.001, 0.62 * half, 0.60)
        assets.box(body, f"{tag}:glass", at, size, f"{tag}:glass", castshadow=False)
        for z in (1.10, 1.50):
            at, size = (0.019, y, z), (0.002, 0.62 * half, 0.012)
            assets.box(body, f"{tag}:bar:{z}", at, size, tag, castshadow=False)
    side = 1 if rng.random() < 0.5 else -1
    assets.ellipsoid(
        body,
        f"{tag}:handle",
        (0.05, y + side * (half - 0.06), 1.03),
        (0.016, 0.05, 0.012),
        f"{tag}:metal",
    )


def add_window(assets: Assets, wall: Wall, y: float, width_m: float, kind: str) -> None:
    """Add a window, middle at y, with the day outside: curtains, a blind, or bare."""
    rng, body, tag = assets.rng(f"window:{wall.name}"), wall.body, f"window:{wall.name}"
    low, high = float(rng.uniform(0.75, 1.0)), float(rng.uniform(1.95, 2.25))
    half, middle = width_m / 2, (low + high) / 2
    view = assets.texture(tag, outdoors)
    assets.painted(tag, view, specular=0.0, emission=_DAYLIGHT)
    assets.plane(body, tag, (0.004, y, middle), (half, (high - low) / 2), FACING, tag)
    bars = int(rng.integers(1, 4))
    for i in range(bars + 1):
        at = (0.014, y - half + 2 * half * i / bars, middle)
        assets.box(
            body,
            f"{tag}:post:{i}",
            at,
            (0.014, 0.026, (high - low) / 2 + 0.03),
            "trim",
            castshadow=False,
        )
    rails = [low, high] + ([low + 0.68 * (high - low)] if rng.random() < 0.4 else [])
    for i, z in enumerate(rails):
        size = (0.014, half + 0.026, 0.026)
        assets.box(body, f"{tag}:rail:{i}", (0.014, y, z), size, "trim", castshadow=False)
    sill = (0.07, y, low - 0.045)
    assets.box(body, f"{tag}:sill", sill, (0.07, half + 0.06, 0.015), "trim", castshadow=False)
    if kind == "blind":
        assets.plain(f"{tag}:slat", (0.72, 0.71, 0.68), emission=0.12)
        drop = float(rng.uniform(0.25, 0.8)) * (high - low)
        for i in range(int(drop / 0.034)):
            at = (0.035, y, high - 0.034 * (i + 0.5))
            assets.box(
                body, f"{tag}:slat:{i}", at, (0.007, half, 0.0125), f"{tag}:slat", castshadow=False
            )
    if kind == "curtains":
        rgb = colour_of(rng, 0.15, 0.75, 0.5)
        assets.cloth(f"{tag}:curtain", rgb, str(rng.choice(["plain", "stripes"])))
        broad = float(rng.uniform(0.22, 0.40))
        bottom = 0.06 if rng.random() < 0.6 else low - 0.12
        for side in (-1, 1):
            fall = _curtain(broad, high + 0.14 - bottom, float(rng.uniform(0, 6)))
            at = (0.075, y + side * (half + 0.02), bottom)
            assets.add(
                body, f"{tag}:curtain:{side}", fall, f"{tag}:curtain", 0, pos=at, castshadow=False
            )
        ends = ((0.075, y - half - 0.3, high + 0.15), (0.075, y + half + 0.3, high + 0.15))
        assets.plain(f"{tag}:rod", (0.25, 0.22, 0.20), specular=0.3)
        assets.capsule(body, f"{tag}:rod", ends, 0.012, f"{tag}:rod", castshadow=False)


def _curtain(width_m: float, height_m: float, phase: float) -> Surface:
    """A curtain in folds, middle of its lower hem at the origin, a closed sheet along y."""
    u = np.linspace(-0.5, 0.5, 40)
    folds = 0.022 * np.sin(2 * np.pi * 5.5 * u + phase) + 0.008 * np.sin(19 * u)
    front = np.column_stack([folds + 0.006, width_m * u])
    back = np.column_stack([folds - 0.006, width_m * u])[::-1]
    ring = np.concatenate([front, back, front[:1]])
    z = np.linspace(height_m, 0.0, 6)
    fuller = np.linspace(0.85, 1.1, 6)
    grid = np.empty((len(z), len(ring), 3))
    grid[..., 0] = ring[:, 0] * fuller[:, None]
    grid[..., 1] = ring[:, 1] * np.linspace(0.92, 1.0, 6)[:, None]
    grid[..., 2] = z[:, None]
    return closed_grid(grid)
