"""Light from a window or lamps: a key light with soft shadows, fills of other colours, ambience."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RoomSpec, Surroundings
from sim.surfaces.assets import Assets
from sim.vectors import about_z

SHARP_M = 0.02  # MuJoCo's own `bulbradius`; of a light that has more, shadows have soft edges
_MOST_SOFT_M = 0.012  # half the width of the softest shadow's edge
_WARM, _COOL = np.array([1.10, 0.98, 0.82]), np.array([0.94, 1.0, 1.08])


def key_way(azimuth_rad: float, elevation_rad: float) -> Floats:
    """The way (3,) in which the key light shines; azimuth as in `sim.specs.RoomSpec`."""
    flat = about_z(azimuth_rad) @ np.array([-0.78, -0.42, 0.0])
    flat /= np.linalg.norm(flat)
    way: Floats = np.cos(elevation_rad) * flat - np.sin(elevation_rad) * np.array([0.0, 0.0, 1.0])
    return way


def add_lights(assets: Assets, room: RoomSpec, around: Surroundings, aim_m: Floats) -> None:
    """Add the key light, which casts shadows, a fill, a lamp that may cast them too, and ambience.

    As in the nominal room all light is directional or ambient, so that both views are lit alike.
    """
    rng = assets.rng("lights")
    key = key_way(room.light_azimuth_rad, around.light_elevation_rad)
    contrast = around.light_contrast
    aside = np.array([-0.45, -np.sign(key[1]) * 0.85, -0.15])
    lamp = {"none": np.array([-0.9, 0.2, 0.1]), "standing": np.array([0.75, 0.4, -0.35])}.get(
        around.lamp, np.array([0.05, 0.05, -1.0])
    )
    if rng.random() < 0.5:
        lamp = lamp * np.array([1.0, -1.0, 1.0])
    two = around.shadow_lights == 2
    if two and around.lamp == "none":  # from above on the other side
        lamp = np.array([-0.5, -np.sign(key[1]) * 0.6, -0.7])
    tint = _WARM if around.lamp != "none" else _COOL
    level = np.array(room.light_rgb) * room.light_gain
    for name, way, strength, colour, shadow in (
        ("key", key, 0.48 + 0.26 * contrast, np.ones(3), True),
        ("fill", aside, 0.28 - 0.14 * contrast, np.ones(3), False),
        ("lamp", lamp, 0.28 if two else 0.16, tint, two),
    ):
        light = (strength * level * colour).tolist()
        gloss = (0.4 * level).tolist() if shadow else [0.0, 0.0, 0.0]
        soft_m = _MOST_SOFT_M * around.light_softness if shadow else 0.0
        add_directional(assets, name, way, aim_m, light, gloss, shadow, SHARP_M + soft_m)
    add_ambience(assets, ((0.40 - 0.08 * contrast) * level).tolist())


def add_directional(
    assets: Assets,
    name: str,
    way: Floats,
    aim_m: Floats,
    diffuse: list[float],
    specular: list[float],
    castshadow: bool,
    radius_m: float = SHARP_M,
) -> None:
    """Add a light that shines along way (3,) at aim_m (3,)."""
    direction = way / np.linalg.norm(way)
    assets.spec.worldbody.add_light(
        name=name,
        type=assets.mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(aim_m - 3.0 * direction).tolist(),
        dir=direction.tolist(),
        diffuse=diffuse,
        ambient=[0.0, 0.0, 0.0],
        specular=specular,
        castshadow=castshadow,
        bulbradius=radius_m,
    )


def add_ambience(assets: Assets, ambient: list[float]) -> None:
    """Light all surfaces alike by the head light.

    A head light with more than an ambient part would move with the camera and light the two views
    differently.
    """
    headlight = assets.spec.visual.headlight
    headlight.active = 1
    headlight.ambient = ambient
    headlight.diffuse = [0.0, 0.0, 0.0]
    headlight.specular = [0.0, 0.0, 0.0]
