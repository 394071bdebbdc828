"""Parameters of person, habits and room, and the records of `sim` that their values make."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable, Mapping

import numpy as np

from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.parameter import choice, fixed, normal, uniform
from sim.anatomy import Anatomy
from sim.camera.colour import NEUTRAL_K, light_rgb
from sim.motion.stage import Values, number
from sim.scene.disturbances import background_change, mover, moving_shadow, together
from sim.scene.extras import Extras
from sim.specs import RGB, Appearance, ObjectSpec, RoomSpec, Surroundings

# Beige paint, beech, camel: hue and saturation as those of skin.
NEAR_SKIN: Mapping[str, RGB] = {
    "wall": (0.78, 0.62, 0.49),
    "table": (0.72, 0.52, 0.38),
    "shirt": (0.70, 0.52, 0.39),
}

# Ranges from the anthropometry and the rig of the scenario catalogue's preface.
PARAMETERS: Mapping[str, Numeric | Choice] = {
    "stature": normal("m", 1.52, 1.90, 1.71, 0.06, "stature of the person"),
    "arm_scale": normal("1", 0.95, 1.05, 1.0, 0.02, "arm length over the average for the stature"),
    "hand_scale": normal("1", 0.92, 1.10, 1.0, 0.03, "hand size over the average"),
    "head_scale": normal("1", 0.94, 1.06, 1.0, 0.02, "head size over the average"),
    "shoulder_scale": normal("1", 0.92, 1.08, 1.0, 0.03, "shoulder breadth over the average"),
    "skin_ita": normal("deg", -50.0, 60.0, 32.0, 8.0, "skin tone, individual typology angle"),
    "hair": choice({"short": 0.6, "long": 0.3, "bald": 0.1}, "hair style"),
    "hair_tone": uniform("1", (0.0, 1.0), 0.05, 0.55, "hair: 0 black, brown, blond, 1 grey"),
    "beard": choice({"no": 0.85, "yes": 0.15}, "whether the person has a beard"),
    "glasses": choice({"no": 0.8, "yes": 0.2}, "whether the person wears glasses"),
    "sleeves": choice({"long": 1.0, "rolled": 0.0, "short": 0.0}, "sleeves; rolled: bare forearms"),
    "shirt_hue": uniform("deg", (0.0, 360.0), 190.0, 250.0, "hue of the shirt"),
    "shirt_saturation": uniform("1", (0.0, 1.0), 0.60, 0.70, "saturation of the shirt (HSV)"),
    "shirt_value": uniform("1", (0.05, 1.0), 0.30, 0.60, "brightness of the shirt (HSV)"),
    "shirt_pattern": choice({"plain": 0.7, "stripes": 0.15, "checks": 0.15}, "print of the shirt"),
    "rest_x": uniform("m", (0.24, 0.45), 0.32, 0.36, "resting palms ahead of the shoulders"),
    "rest_y": uniform("m", (0.12, 0.35), 0.18, 0.23, "resting palms from the mid-plane"),
    "hand_inward": uniform("rad", (-0.2, 0.9), 0.25, 0.50, "resting fingers, turn inwards"),
    "hand_curl": uniform("1", (0.0, 0.5), 0.06, 0.14, "curl of relaxed fingers"),
    "elbow_swivel": normal("rad", 0.26, 0.79, 0.52, 0.09, "elbow outward of straight down"),
    "head_sway": uniform("m", (0.0, 0.02), 0.003, 0.010, "amplitude of the head's sway"),
    "tremor": uniform("m", (0.0, 0.005), 0.001, 0.003, "amplitude of a free hand's tremor"),
    "table_height": uniform("m", (0.68, 0.78), 0.72, 0.74, "height of the table top"),
    "table_near": uniform("m", (0.10, 0.25), 0.15, 0.18, "near edge ahead of the shoulders"),
    "table_surface": choice({"wood": 0.6, "cloth": 0.2, "plain": 0.2}, "what the table is of"),
    "table_hue": uniform("deg", (0.0, 360.0), 200.0, 220.0, "hue of the table"),
    "table_saturation": uniform("1", (0.0, 1.0), 0.08, 0.14, "saturation of the table (HSV)"),
    "table_value": uniform("1", (0.15, 1.0), 0.49, 0.57, "brightness of the table (HSV)"),
    "wall_hue": uniform("deg", (0.0, 360.0), 60.0, 120.0, "hue of the walls"),
    "wall_saturation": uniform("1", (0.0, 1.0), 0.03, 0.07, "saturation of the walls (HSV)"),
    "wall_value": uniform("1", (0.15, 1.0), 0.59, 0.67, "brightness of the walls (HSV)"),
    "near_skin": choice(
        {"none": 1.0, "wall": 0.0, "table": 0.0, "shirt": 0.0, "all": 0.0},
        "what is of a colour near skin instead: beige wall, wooden table, camel shirt",
    ),
    "light_gain": normal("1", 0.3, 1.7, 1.0, 0.04, "brightness of the light"),
    "light_temperature": fixed("K", 2700.0, 7500.0, NEUTRAL_K, "colour temperature of the light"),
    "light_azimuth": normal("deg", -45.0, 45.0, 0.0, 6.0, "key light, turned about the vertical"),
    "shadow": choice(
        {"none": 1.0, "slow": 0.0, "fast": 0.0}, "a shadow that sweeps over table and person"
    ),
    "mover": choice(
        {"none": 1.0, "arm": 0.0, "balloon": 0.0}, "a second mover of the colour of skin"
    ),
    "background_change": choice(
        {"none": 1.0, "box": 0.0, "picture": 0.0, "chair": 0.0},
        "what came into the room after the background was learnt",
    ),
    "start": choice(
        {"apart": 1.0, "crossed": 0.0, "hidden": 0.0},
        "hands in the first frames: crossed, or one hidden, before they go to their places",
    ),
    "texture": uniform("1", (0.0, 1.0), 0.0, 1.0, "which surface textures"),
}


def anatomy_of(values: Values) -> Anatomy:
    """The person's measures."""
    names = ("stature", "arm_scale", "hand_scale", "head_scale", "shoulder_scale")
    return Anatomy.of(*(number(values, name) for name in names))


def appearance_of(values: Values) -> Appearance:
    """The person's looks: skin, hair, clothes."""
    return Appearance(
        skin_rgb=skin_rgb(number(values, "skin_ita")),
        hair_rgb=hair_rgb(number(values, "hair_tone")),
        shirt_rgb=_colour(values, "shirt"),
        sleeves=str(values["sleeves"]),
        beard=values["beard"] == "yes",
        glasses=values["glasses"] == "yes",
        hair=str(values["hair"]),
        shirt_pattern=str(values["shirt_pattern"]),
        # A parameter of varied surroundings alone.
        expression=str(values.get("expression", "neutral")),
    )


def room_of(
    values: Values, objects: tuple[ObjectSpec, ...], surroundings: Surroundings | None = None
) -> RoomSpec:
    """Table, walls and light, with these objects, in these surroundings."""
    nominal = RoomSpec()
    return RoomSpec(
        table_height_m=number(values, "table_height"),
        table_near_x_m=number(values, "table_near"),
        table_depth_m=float(values.get("table_depth", nominal.table_depth_m)),
        table_width_m=float(values.get("table_width", nominal.table_width_m)),
        table_rgb=_colour(values, "table"),
        table_surface=str(values["table_surface"]),
        wall_rgb=_colour(values, "wall"),
        light_gain=number(values, "light_gain"),
        light_rgb=light_rgb(number(values, "light_temperature")),
        light_azimuth_rad=number(values, "light_azimuth"),
        texture_seed=int(number(values, "texture") * 999_999),
        objects=objects,
        surroundings=surroundings,
    )


def extras_of(
    values: Values, streams: Callable[[str], np.random.Generator], duration_s: float
) -> Extras:
    """Disturbances that do not belong to the scenario's motion: shadow, mover, changed background.

    duration_s: how long they go on.
    """
    skin = skin_rgb(number(values, "skin_ita"))
    height, near = number(values, "table_height"), number(values, "table_near")
    azimuth = number(values, "light_azimuth")
    change = str(values["background_change"])
    elevation = number(values, "light_elevation") if "light_elevation" in values else None
    shadow = str(values["shadow"])
    return together(
        (
            moving_shadow(shadow, azimuth, streams("shadow"), duration_s, elevation),
            mover(str(values["mover"]), skin, height, near, streams("mover"), duration_s),
            background_change(change, near, streams("background_change")),
        )
    )


def _colour(values: Values, surface: str) -> RGB:
    """The colour of "wall", "table" or "shirt": by hue, saturation and value, or of NEAR_SKIN."""
    if values["near_skin"] in (surface, "all"):
        return NEAR_SKIN[surface]
    hue = (number(values, f"{surface}_hue") / (2 * math.pi)) % 1.0
    return colorsys.hsv_to_rgb(
        hue, number(values, f"{surface}_saturation"), number(values, f"{surface}_value")
    )


def hair_rgb(tone: float) -> RGB:
    """Hair colour of a tone 0-1, black over brown and blond to grey: always greyer than skin."""
    tones = [0.0, 0.35, 0.60, 0.85, 1.0]
    red, green, blue = (
        float(np.interp(tone, tones, shades))
        for shades in (
            [0.050, 0.150, 0.300, 0.680, 0.600],
            [0.045, 0.112, 0.238, 0.600, 0.590],
            [0.042, 0.100, 0.200, 0.460, 0.580],
        )
    )
    return red, green, blue


def skin_rgb(ita_rad: float) -> RGB:
    """Skin colour (display red, green, blue 0-1) of an individual typology angle [rad].

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
