"""Person, habits and room: their parameters, and what values of them look like."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable, Mapping

import numpy as np

from scenarios.parameters import Choice, Numeric, normal, uniform
from sim.anatomy import Anatomy
from sim.extras import NO_EXTRAS, Extras
from sim.specs import RGB, Appearance, ObjectSpec, RoomSpec
from sim.stage import Values, number

# Ranges from the anthropometry and the rig of the scenario catalogue's preface.
PARAMETERS: Mapping[str, Numeric | Choice] = {
    "stature": normal("m", 1.52, 1.90, 1.71, 0.06, "stature of the person"),
    "arm_scale": normal("1", 0.95, 1.05, 1.0, 0.02, "arm length over the average for the stature"),
    "hand_scale": normal("1", 0.92, 1.10, 1.0, 0.03, "hand size over the average"),
    "head_scale": normal("1", 0.94, 1.06, 1.0, 0.02, "head size over the average"),
    "shoulder_scale": normal("1", 0.92, 1.08, 1.0, 0.03, "shoulder breadth over the average"),
    "skin_ita": normal("deg", -50.0, 60.0, 32.0, 8.0, "skin tone, individual typology angle"),
    "shirt_hue": uniform("deg", (0.0, 360.0), 190.0, 250.0, "hue of the shirt"),
    "shirt_value": uniform("1", (0.05, 1.0), 0.30, 0.60, "brightness of the shirt (HSV)"),
    "rest_x": uniform("m", (0.24, 0.45), 0.32, 0.36, "resting palms ahead of the shoulders"),
    "rest_y": uniform("m", (0.12, 0.35), 0.18, 0.23, "resting palms from the mid-plane"),
    "hand_inward": uniform("rad", (-0.2, 0.9), 0.25, 0.50, "resting fingers, turn inwards"),
    "hand_curl": uniform("1", (0.0, 0.5), 0.06, 0.14, "curl of relaxed fingers"),
    "elbow_swivel": normal("rad", 0.26, 0.79, 0.52, 0.09, "elbow outward of straight down"),
    "head_sway": uniform("m", (0.0, 0.02), 0.003, 0.010, "amplitude of the head's sway"),
    "tremor": uniform("m", (0.0, 0.005), 0.001, 0.003, "amplitude of a free hand's tremor"),
    "table_height": uniform("m", (0.68, 0.78), 0.72, 0.74, "height of the table top"),
    "table_near": uniform("m", (0.10, 0.25), 0.15, 0.18, "near edge ahead of the shoulders"),
    "light_gain": normal("1", 0.3, 1.7, 1.0, 0.04, "brightness of the light"),
    "texture": uniform("1", (0.0, 1.0), 0.0, 1.0, "which surface textures"),
}


def anatomy_of(values: Values) -> Anatomy:
    """The person's measures."""
    names = ("stature", "arm_scale", "hand_scale", "head_scale", "shoulder_scale")
    return Anatomy.of(*(number(values, name) for name in names))


def appearance_of(values: Values) -> Appearance:
    """How the person looks."""
    hue = (number(values, "shirt_hue") / (2 * math.pi)) % 1.0
    shirt = colorsys.hsv_to_rgb(hue, 0.65, number(values, "shirt_value"))
    return Appearance(skin_rgb=skin_rgb(number(values, "skin_ita")), shirt_rgb=shirt)


def room_of(values: Values, objects: tuple[ObjectSpec, ...]) -> RoomSpec:
    """Table, walls and light, with these objects."""
    return RoomSpec(
        table_height_m=number(values, "table_height"),
        table_near_x_m=number(values, "table_near"),
        light_gain=number(values, "light_gain"),
        texture_seed=int(number(values, "texture") * 999_999),
        objects=objects,
    )


def extras_of(
    values: Values, streams: Callable[[str], np.random.Generator], duration_s: float
) -> Extras:
    """What disturbs the scene without belonging to the scenario."""
    return NO_EXTRAS


def skin_rgb(ita_rad: float) -> RGB:
    """A skin colour (display red, green, blue 0-1) of this individual typology angle.

    ITA = atan((L* - 50) / b*) (Chardon et al. 1991); a* and b* follow the usual spread: both
    least in very light and very dark skin.
    """
    from_middle = abs(ita_rad - 0.3) / 1.3
    a, b = 18.0 - 5.0 * from_middle, 25.0 - 9.0 * from_middle
    L = 50.0 + b * math.tan(ita_rad)
    fy = (L + 16.0) / 116.0

    def linear(f: float) -> float:
        return f**3 if f > 6 / 29 else 3 * (6 / 29) ** 2 * (f - 4 / 29)

    # CIE 1976 L*a*b* to XYZ for D65, to linear sRGB, to display values (IEC 61966-2-1).
    X, Y, Z = 0.95047 * linear(fy + a / 500), linear(fy), 1.08883 * linear(fy - b / 200)
    rgb = (
        3.2406 * X - 1.5372 * Y - 0.4986 * Z,
        -0.9689 * X + 1.8758 * Y + 0.0415 * Z,
        0.0557 * X - 0.2040 * Y + 1.0570 * Z,
    )
    red, green, blue = (
        min(max(12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055, 0.0), 1.0)
        for c in rgb
    )
    return red, green, blue
