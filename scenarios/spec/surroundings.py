"""Parameters of varied surroundings: the whole range of room, light, rig and person.

They replace or join the standard ones (`scenarios.spec.standard`) where a scenario says
`surroundings: varied`.
"""

from __future__ import annotations

import colorsys
from collections.abc import Mapping

from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.distributions import Uniform
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.parameter import choice, uniform
from scenarios.spec.standard import STANDARD
from sim.motion.stage import Values, number
from sim.person.face import EXPRESSIONS
from sim.person.hair import HAIR
from sim.specs import Surroundings
from sim.surfaces import textures
from sim.surroundings import words

NOMINAL, VARIED = "nominal", "varied"


def _whole(name: str, low: float | None = None, high: float | None = None) -> Numeric:
    """The standard parameter, uniform over its range or from `low` to `high` of it."""
    usual = STANDARD[name]
    assert isinstance(usual, Numeric)
    ends = usual.range[0] if low is None else low, usual.range[1] if high is None else high
    nominal = Uniform(kind="uniform", low=ends[0], high=ends[1])
    return usual.model_copy(update={"nominal": nominal})


def _even(name: str) -> Choice:
    """The standard choice with its options equally likely."""
    usual = STANDARD[name]
    assert isinstance(usual, Choice)
    weights = (1.0,) * len(usual.choices)
    return usual.model_copy(update={"weights": weights})


def _one_of(words_: tuple[str, ...], meaning: str) -> Choice:
    return choice(dict.fromkeys(words_, 1.0), meaning)


# Of person, light and rig: the standard parameters, each over the range of the scenario catalogue.
_WIDER: Mapping[str, Numeric | Choice] = {
    **{
        name: _whole(name)
        for name in (
            *("stature", "arm_scale", "hand_scale", "head_scale", "shoulder_scale", "skin_ita"),
            *("hair_tone", "table_height", "light_temperature", "focal", "rig_height"),
            *("rig_tilt", "rig_distance", "vergence", "shirt_hue", "table_hue", "wall_hue"),
        )
    },
    "baseline": _whole("baseline", 0.06, 0.12),
    "hair": choice({cut: 1.0 if cut == "bald" else 3.0 for cut in HAIR}, "cut of the hair"),
    "expression": choice(
        {word: 2.0 if word == "neutral" else 1.0 for word in EXPRESSIONS}, "expression of the face"
    ),
    "beard": choice({"no": 0.7, "yes": 0.3}, "whether the person has a beard"),
    "glasses": choice({"no": 0.7, "yes": 0.3}, "whether the person wears glasses"),
    "sleeves": _even("sleeves"),
    "shirt_saturation": _whole("shirt_saturation", 0.0, 0.75),
    "shirt_value": _whole("shirt_value", 0.08, 0.95),
    "shirt_pattern": _one_of(textures.PATTERNS, "print of the shirt"),
    "table_surface": _even("table_surface"),
    "table_saturation": _whole("table_saturation", 0.0, 0.25),
    "table_value": _whole("table_value", 0.25, 0.9),
    "wall_saturation": _whole("wall_saturation", 0.0, 0.35),
    "wall_value": _whole("wall_value", 0.4, 0.92),
    "near_skin": choice(
        {"none": 0.76, "wall": 0.06, "table": 0.06, "shirt": 0.06, "all": 0.06},
        "what is of a colour near skin instead: beige wall, wooden table, camel shirt",
    ),
    "light_gain": _whole("light_gain", 0.8, 1.3),
    "light_azimuth": uniform(
        "deg", (-45.0, 105.0), -45.0, 105.0, "key light, turned about the vertical"
    ),
}

# Of the room alone. The choices are those that can be drawn; a scenario may weigh them anew.
_ROOM: Mapping[str, Numeric | Choice] = {
    "arrangement": uniform("1", (0.0, 1.0), 0.0, 1.0, "which places, sizes and patterns"),
    "room_depth": uniform("m", (1.3, 2.6), 1.3, 2.6, "back wall behind the shoulders"),
    "room_width": uniform("m", (3.4, 5.2), 3.4, 5.2, "from side wall to side wall"),
    "wall": _one_of(words.WALLS, "what the walls are covered with"),
    "floor": _one_of(words.FLOORS, "what the floor is covered with"),
    "floor_tone": uniform("1", (0.0, 1.0), 0.0, 1.0, "floor: wood, beige, grey, blue, red"),
    "floor_value": uniform("1", (0.1, 0.8), 0.2, 0.62, "brightness of the floor"),
    "door": choice({"none": 0.3, "panelled": 0.3, "glazed": 0.2, "plain": 0.2}, "kind of door"),
    "window": choice({"none": 0.3, "curtains": 0.3, "blind": 0.2, "bare": 0.2}, "kind of window"),
    "shelves": _one_of(words.SHELVES, "what holds books or things"),
    "pictures": uniform("1", (0.0, 6.0), 0.0, 4.0, "pictures on the walls, rounded"),
    "poster": choice({"no": 0.75, "yes": 0.25}, "a poster of a person on a wall"),
    "plants": uniform("1", (0.0, 4.0), 0.0, 2.5, "plants on the floor, rounded"),
    "screen": choice({"none": 0.5, "wall": 0.25, "table": 0.25}, "a screen that is on"),
    "chair": _one_of(words.CHAIRS, "the person's chair"),
    "table_shape": _one_of(words.TABLE_SHAPES, "outline of the table"),
    "table_legs": _one_of(words.TABLE_LEGS, "what the table stands on"),
    "table_depth": uniform("m", (0.6, 0.95), 0.62, 0.95, "depth of the table"),
    "table_width": uniform("m", (1.15, 1.9), 1.2, 1.9, "width of the table"),
    "clutter": uniform("1", (0.0, 10.0), 0.0, 8.0, "things on the table that may be put, rounded"),
    "floor_clutter": uniform("1", (0.0, 4.0), 0.0, 3.0, "boxes and bins on the floor, rounded"),
    "bystander": choice({"none": 0.7, "still": 0.15, "moving": 0.15}, "a second person, behind"),
    "light_elevation": uniform("deg", (15.0, 75.0), 22.0, 68.0, "key light above the horizon"),
    "light_softness": uniform("1", (0.0, 1.0), 0.0, 1.0, "softness of shadows' edges"),
    "light_contrast": uniform("1", (0.0, 1.0), 0.0, 1.0, "from even light to light of one side"),
    "lamp": _one_of(words.LAMPS, "a lamp that is lit besides"),
    "shadow_lights": choice({"one": 1.0, "two": 0.0}, "lights with shadows: key light, and lamp"),
}

PARAMETERS: Mapping[str, Numeric | Choice] = {**_WIDER, **_ROOM}
_STANDARD: Mapping[str, Mapping[str, Numeric | Choice]] = {
    NOMINAL: STANDARD,
    VARIED: {**STANDARD, **PARAMETERS},
}
ROOM_CHOICES: Mapping[str, tuple[str, ...]] = {
    name: parameter.choices for name, parameter in _ROOM.items() if isinstance(parameter, Choice)
}
ROOM_PARAMETERS = frozenset(_ROOM)
ROOM_RANGES: Mapping[str, tuple[float, float]] = {
    name: parameter.range for name, parameter in _ROOM.items() if isinstance(parameter, Numeric)
}
RIG = ("focal", "baseline", "rig_height", "rig_tilt", "rig_distance", "vergence")

# Hue [deg] and saturation of the floor's tones: woods, beige, grey, blue, red.
_FLOOR_TONES = ((24.0, 0.42), (32.0, 0.55), (38.0, 0.22), (210.0, 0.06), (215.0, 0.30), (2.0, 0.38))


def standard_parameters(surroundings: str) -> Mapping[str, Numeric | Choice]:
    """The parameters that every scenario has in these surroundings unless it says otherwise."""
    return _STANDARD[surroundings]


def surroundings_of(values: Values) -> Surroundings | None:
    """The surroundings of concrete values in SI units; None where they have none."""
    if "arrangement" not in values:
        return None
    hue, saturation = _FLOOR_TONES[
        min(int(number(values, "floor_tone") * len(_FLOOR_TONES)), len(_FLOOR_TONES) - 1)
    ]

    def word(name: str) -> str:
        return str(values[name])

    def count(name: str) -> int:
        return round(number(values, name))

    return Surroundings(
        arrangement=int(number(values, "arrangement") * 999_999_999),
        depth_m=number(values, "room_depth"),
        half_width_m=number(values, "room_width") / 2,
        wall=word("wall"),
        floor=word("floor"),
        floor_rgb=colorsys.hsv_to_rgb(hue / 360, saturation, number(values, "floor_value")),
        door=word("door"),
        window=word("window"),
        shelves=word("shelves"),
        pictures=count("pictures"),
        poster=word("poster") == "yes",
        plants=count("plants"),
        screen=word("screen"),
        chair=word("chair"),
        table_shape=word("table_shape"),
        table_legs=word("table_legs"),
        clutter=count("clutter"),
        floor_clutter=count("floor_clutter"),
        bystander=word("bystander"),
        light_elevation_rad=number(values, "light_elevation"),
        light_softness=number(values, "light_softness"),
        light_contrast=number(values, "light_contrast"),
        lamp=word("lamp"),
        shadow_lights={"one": 1, "two": 2}[word("shadow_lights")],
    )
