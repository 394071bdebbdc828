"""A scenario: every number a named parameter with unit, range and nominal distribution.

A *logical* scenario is the record below; `concrete` turns it, with a seed, into values, `perform`
these into a `sim.script.Performance`. Values are kept in physical units; `latent` gives the same
value as a standard-normal number for those who search.
"""

from __future__ import annotations

import colorsys
import difflib
import hashlib
import json
import math
import re
from collections.abc import Collection, Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    Tag,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError
from scipy.special import ndtr, ndtri

from pjpdaf.errors import BenchError
from sim.anatomy import Anatomy
from sim.gestures import GESTURES, Stage, Value
from sim.motion import Performer
from sim.randomness import generator
from sim.script import Performance
from sim.specs import RGB, Appearance, RigSpec, RoomSpec, SceneSpec, SensorSpec

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Whole = Annotated[int, Strict()]
Text = Annotated[str, Strict()]
Name = Annotated[str, Strict(), Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=60)]

# Unit -> (base unit, factor). A parameter is kept in its own unit; text may use any of its kind.
UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("m", 1.0),
    "cm": ("m", 0.01),
    "mm": ("m", 0.001),
    "m/s": ("m/s", 1.0),
    "cm/s": ("m/s", 0.01),
    "mm/s": ("m/s", 0.001),
    "km/h": ("m/s", 1 / 3.6),
    "s": ("s", 1.0),
    "ms": ("s", 0.001),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180.0),
    "px": ("px", 1.0),
    "grey": ("grey", 1.0),
    "1": ("1", 1.0),
}
Unit = Literal[
    "m", "cm", "mm", "m/s", "cm/s", "mm/s", "km/h", "s", "ms", "rad", "deg", "px", "grey", "1"
]
_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*([^\s\d.+-]\S*|1)?\s*", re.ASCII
)

MAX_FRAMES = 20_000


def nearest(word: str, known: Collection[str]) -> str:
    """ "; did you mean X?" for the known word that looks most like this one, else nothing."""
    close = difflib.get_close_matches(word, sorted(known), n=1)
    return f"; did you mean {close[0]}?" if close else ""


def quantity(text: str, unit: str) -> float:
    """A number, with or without a unit of the same kind, in `unit`. Raises ValueError."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"must be a number in {unit}, got {text[:60]!r}")
    value, given = float(match[1]), match[2]
    if not math.isfinite(value):
        raise ValueError(f"must be finite, got {text[:60]!r}")
    if given is None:
        return value
    base, factor = UNITS[unit]
    if given not in UNITS or UNITS[given][0] != base:
        fit = ", ".join(name for name, (kind, _) in UNITS.items() if kind == base)
        raise ValueError(f"must be in {fit}, got unit {given[:20]!r}")
    # 0.3 m/s stays 0.3: no factor where there is nothing to convert.
    return value if given == unit else value * UNITS[given][1] / factor


class Record(BaseModel):
    """Frozen, and no field but the declared ones."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Uniform(Record):
    """Equally likely from low to high (left out: the parameter's range)."""

    kind: Literal["uniform"]
    low: Number | None = None
    high: Number | None = None


class LogUniform(Record):
    """The logarithm equally likely from low to high (left out: the parameter's range)."""

    kind: Literal["log-uniform"]
    low: Number | None = None
    high: Number | None = None


class Normal(Record):
    """A normal distribution cut to the parameter's range."""

    kind: Literal["normal"]
    mean: Number
    sd: Annotated[Number, Field(gt=0)]


class Fixed(Record):
    """Always this value; the range says how far it may be set."""

    kind: Literal["fixed"]
    value: Number


Distribution = Annotated[Uniform | LogUniform | Normal | Fixed, Field(discriminator="kind")]


class Numeric(Record):
    """A number: unit, range [least, greatest], and what it nominally is."""

    unit: Unit
    range: tuple[Number, Number]
    nominal: Distribution
    meaning: Text = ""

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, data: Any) -> Any:
        """Text such as "0.3 m/s" or "30 cm" becomes the number in this parameter's unit."""
        if not isinstance(data, Mapping) or data.get("unit") not in UNITS:
            return data

        def plain(value: Any, place: str) -> Any:
            if not isinstance(value, str):
                return value
            try:
                return quantity(value, data["unit"])
            except ValueError as fault:
                raise PydanticCustomError(
                    "quantity", "{fault}", {"fault": str(fault), "at": place}
                ) from None

        read = dict(data)
        if isinstance(read.get("range"), list | tuple):
            read["range"] = [plain(v, f"range.{i}") for i, v in enumerate(read["range"])]
        if isinstance(read.get("nominal"), Mapping):
            read["nominal"] = {
                key: plain(v, f"nominal.{key}") if key != "kind" else v
                for key, v in read["nominal"].items()
            }
        return read

    @field_validator("range")
    @classmethod
    def _forward(cls, ends: tuple[float, float]) -> tuple[float, float]:
        if ends[0] > ends[1]:
            raise PydanticCustomError(
                "reversed",
                "{fault}",
                {"fault": f"range is reversed: {ends[0]:g} is greater than {ends[1]:g}"},
            )
        return ends

    @model_validator(mode="after")
    def _nominal_inside(self) -> Self:
        low, high = self.range
        for key, value in self.nominal.model_dump(exclude={"kind", "sd"}).items():
            if value is not None and not low <= value <= high:
                raise _fault(
                    f"{value:g} is outside the range {low:g} to {high:g} {self.unit}",
                    f"nominal.{key}",
                )
        if isinstance(self.nominal, Uniform | LogUniform):
            a, b = self.bounds
            if a > b:
                raise _fault(f"low {a:g} is greater than high {b:g}", "nominal.low")
            if isinstance(self.nominal, LogUniform) and a <= 0:
                raise _fault(f"log-uniform needs a low end above 0, got {a:g}", "nominal")
        return self

    @property
    def bounds(self) -> tuple[float, float]:
        """Ends of the nominal distribution: its own where it has any, else the range."""
        low, high = self.range
        if isinstance(self.nominal, Uniform | LogUniform):
            low = low if self.nominal.low is None else self.nominal.low
            high = high if self.nominal.high is None else self.nominal.high
        return low, high

    def at(self, share: float) -> float:
        """The value below which this share (0-1) of the nominal distribution lies: F^-1(share)."""
        low, high = self.bounds
        nominal = self.nominal
        if isinstance(nominal, Fixed):
            return nominal.value
        if isinstance(nominal, Normal):
            first, last = (float(ndtr((end - nominal.mean) / nominal.sd)) for end in (low, high))
            value = nominal.mean + nominal.sd * float(ndtri(first + share * (last - first)))
            return min(max(value, low), high)
        if isinstance(nominal, LogUniform):
            return float(min(max(low * (high / low) ** share, low), high))
        return low + share * (high - low)

    def share(self, value: float) -> float:
        """F(value) of the nominal distribution, the inverse of `at` (1/2 for a fixed one)."""
        low, high = self.bounds
        nominal = self.nominal
        if isinstance(nominal, Fixed) or low == high:
            return 0.5
        if isinstance(nominal, Normal):
            first, here, last = (
                float(ndtr((end - nominal.mean) / nominal.sd)) for end in (low, value, high)
            )
            below = (here - first) / (last - first)
        elif isinstance(nominal, LogUniform):
            below = math.log(value / low) / math.log(high / low)
        else:
            below = (value - low) / (high - low)
        return min(max(below, 0.0), 1.0)

    def check(self, name: str, value: Value) -> float:
        """A value set by hand: a number or text with a unit. Raises BenchError naming the range."""
        low, high = self.range
        try:
            number = quantity(value, self.unit) if isinstance(value, str) else float(value)
        except ValueError as fault:
            raise BenchError(f"{name}: {fault} (range {low:g} to {high:g} {self.unit})") from None
        if not low <= number <= high:
            ends = f"{low:g} to {high:g} {self.unit}"
            raise BenchError(f"{name}: {number:g} {self.unit} is outside its range {ends}")
        return number


class Choice(Record):
    """One of some words, equally likely or by weight."""

    choices: Annotated[tuple[Name, ...], Field(min_length=1)]
    weights: tuple[Annotated[Number, Field(ge=0)], ...] | None = None
    meaning: Text = ""

    @model_validator(mode="after")
    def _weights_fit(self) -> Self:
        if self.weights is not None:
            if len(self.weights) != len(self.choices):
                raise _fault(
                    f"{len(self.weights)} weights for {len(self.choices)} choices", "weights"
                )
            if sum(self.weights) <= 0:
                raise _fault("at least one weight must be above 0", "weights")
        return self

    def at(self, share: float) -> str:
        """The choice at this share (0-1) of the cumulated weights."""
        weights = self.weights or (1.0,) * len(self.choices)
        left = share * sum(weights)
        for choice, weight in zip(self.choices, weights, strict=True):
            left -= weight
            if left < 0:
                return choice
        return [c for c, w in zip(self.choices, weights, strict=True) if w > 0][-1]

    def check(self, name: str, value: Value) -> str:
        """A value set by hand. Raises BenchError naming the choices."""
        if value not in self.choices:
            known = ", ".join(self.choices)
            hint = nearest(str(value), self.choices)
            raise BenchError(f"{name}: must be one of {known}, got {str(value)[:60]!r}{hint}")
        return str(value)


def _fault(message: str, at: str) -> PydanticCustomError:
    """A fault of a part of a record: `at` is the path below it that the loader points to."""
    return PydanticCustomError("fault", "{fault}", {"fault": message, "at": at})


def _sort_of(data: Any) -> str:
    if isinstance(data, Choice) or (isinstance(data, Mapping) and "choices" in data):
        return "choice"
    return "numeric"


Parameter = Annotated[
    Annotated[Numeric, Tag("numeric")] | Annotated[Choice, Tag("choice")], Discriminator(_sort_of)
]


def _standard() -> dict[str, Numeric | Choice]:
    """Person, habits, room, rig and sensor: what every scenario has unless it says otherwise.

    Ranges from the anthropometry and the rig of the scenario catalogue's preface.
    """

    def normal(unit: Unit, low: float, high: float, mean: float, sd: float, what: str) -> Numeric:
        nominal = Normal(kind="normal", mean=mean, sd=sd)
        return Numeric(unit=unit, range=(low, high), nominal=nominal, meaning=what)

    def uniform(unit: Unit, ends: tuple[float, float], a: float, b: float, what: str) -> Numeric:
        nominal = Uniform(kind="uniform", low=a, high=b)
        return Numeric(unit=unit, range=ends, nominal=nominal, meaning=what)

    return {
        "stature": normal("m", 1.52, 1.90, 1.71, 0.06, "stature of the person"),
        "arm_scale": normal(
            "1", 0.95, 1.05, 1.0, 0.02, "arm length over the average for the stature"
        ),
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
        "focal": normal("px", 420.0, 700.0, 540.0, 10.0, "focal length of both cameras"),
        "baseline": normal("m", 0.06, 0.30, 0.09, 0.003, "distance between the cameras"),
        "rig_height": normal("m", 1.20, 1.60, 1.36, 0.02, "height of the cameras"),
        "rig_tilt": normal("rad", 0.0, 0.44, 0.295, 0.01, "downward tilt of the cameras"),
        "rig_distance": normal("m", 1.10, 1.70, 1.32, 0.03, "cameras ahead of the shoulders"),
        "vergence": normal("rad", 0.0, 0.09, 0.0, 0.005, "angle between the optical axes"),
        "noise_sd": normal("grey", 0.0, 12.0, 3.0, 0.5, "sensor noise, standard deviation"),
    }


STANDARD: Mapping[str, Numeric | Choice] = _standard()


class Motion(Record):
    """Which family of motion plays the parameters."""

    kind: Literal["calm_table", "drink", "cross", "bounce", "speed_ladder"]


class Scenario(Record):
    """A logical scenario. `family` names its random streams: twins share one, and their draws."""

    name: Name
    version: Annotated[Whole, Field(ge=1)] = 1
    group: Name
    summary: Text
    thesis: Text | None = None
    family: Name
    fps: Annotated[Number, Field(ge=1, le=30)] = 3.0
    frames: Annotated[Whole, Field(ge=1, le=MAX_FRAMES)]
    background_frames: Annotated[Whole, Field(ge=0, le=500)] = 10
    motion: Motion
    parameters: dict[Name, Parameter]

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """The standard parameters are added; a family's own must be there, and no others."""
        own = GESTURES[self.motion.kind].parameters
        for name in self.parameters:
            if name not in own and name not in STANDARD:
                hint = nearest(name, (*own, *STANDARD))
                raise _fault(
                    f"{self.motion.kind} has no such parameter{hint}", f"parameters.{name}"
                )
        for name in own:
            if name not in self.parameters:
                raise _fault(f"{self.motion.kind} needs the parameter {name}", "parameters")
        for name, parameter in self.parameters.items():
            if name in STANDARD and isinstance(parameter, Numeric):
                usual = STANDARD[name]
                if isinstance(usual, Numeric) and UNITS[parameter.unit] != UNITS[usual.unit]:
                    raise _fault(f"unit must be {usual.unit}", f"parameters.{name}.unit")
        merged = dict(STANDARD) | self.parameters
        object.__setattr__(self, "parameters", merged)
        return self


def canonical(record: BaseModel) -> str:
    """The one JSON text of a record: sorted keys, no spaces."""
    return json.dumps(record.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))


def digest(scenario: Scenario) -> str:
    """SHA-256 of the canonical JSON of a scenario, hexadecimal."""
    return hashlib.sha256(canonical(scenario).encode()).hexdigest()


SETTINGS = ("frames", "fps", "background_frames")  # fields that `--set` may change as well


def concrete(
    scenario: Scenario, seed: int, overrides: Mapping[str, Value] | None = None
) -> dict[str, Value]:
    """The values of all parameters for a seed, each in its parameter's unit.

    Each draw is addressed by (seed, family, parameter): changing one moves no other, and twins of a
    family share those of the same name. overrides: parameter -> number, or text such as "0.3 m/s";
    raises BenchError with unit and range for one that does not fit.
    """
    overrides = dict(overrides or {})
    known = (*scenario.parameters, *SETTINGS)
    for name in overrides:
        if name not in known:
            listed = ", ".join(sorted(known))
            what = f"{name[:60]!r}{nearest(name, known) or ';'}"
            raise BenchError(f"{scenario.name} has no parameter {what} known: {listed}")
    values: dict[str, Value] = {}
    for name, parameter in scenario.parameters.items():
        if name in overrides:
            values[name] = parameter.check(name, overrides[name])
        else:
            share = float(generator(seed, f"{scenario.family}/{name}").random())
            values[name] = parameter.at(share)
    return values


draw = concrete


def latent(parameter: Numeric, value: float) -> float:
    """The standard-normal number z of a value: Phi^-1(F(value))."""
    return float(ndtri(parameter.share(value)))


def _setting(scenario: Scenario, overrides: Mapping[str, Value], name: str) -> float:
    if name not in overrides:
        return float(getattr(scenario, name))
    least, most = {"fps": (1, 30), "frames": (1, MAX_FRAMES), "background_frames": (0, 500)}[name]
    try:
        number = float(overrides[name])
        if not math.isfinite(number):
            raise ValueError
    except ValueError:
        raise BenchError(
            f"{name}: must be a number from {least} to {most}, got {str(overrides[name])[:60]!r}"
        ) from None
    if name != "fps" and not number.is_integer():
        raise BenchError(f"{name}: must be a whole number from {least} to {most}, got {number:g}")
    if not least <= number <= most:
        raise BenchError(f"{name}: {number:g} is outside its range {least} to {most}")
    return number


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


def scene_of(scenario: Scenario, values: Mapping[str, Value]) -> SceneSpec:
    """The scene of concrete values in SI units."""
    v = {name: value for name, value in values.items() if isinstance(value, float)}
    shirt = colorsys.hsv_to_rgb((v["shirt_hue"] / (2 * math.pi)) % 1.0, 0.65, v["shirt_value"])
    return SceneSpec(
        anatomy=Anatomy.of(
            v["stature"], v["arm_scale"], v["hand_scale"], v["head_scale"], v["shoulder_scale"]
        ),
        appearance=Appearance(skin_rgb=skin_rgb(v["skin_ita"]), shirt_rgb=shirt),
        room=RoomSpec(
            table_height_m=v["table_height"],
            table_near_x_m=v["table_near"],
            light_gain=v["light_gain"],
            texture_seed=int(v["texture"] * 999_999),
            objects=GESTURES[scenario.motion.kind].objects(values),
        ),
        rig=RigSpec(
            focal_px=v["focal"],
            baseline_m=v["baseline"],
            height_m=v["rig_height"],
            distance_m=v["rig_distance"],
            tilt_rad=v["rig_tilt"],
            vergence_rad=v["vergence"],
        ),
        sensor=SensorSpec(noise_sd=v["noise_sd"]),
    )


def in_si(scenario: Scenario, values: Mapping[str, Value]) -> dict[str, Value]:
    """The same values with every number in the base unit of its kind (m, m/s, s, rad, ...)."""
    converted: dict[str, Value] = {}
    for name, value in values.items():
        parameter = scenario.parameters[name]
        if isinstance(parameter, Numeric):
            converted[name] = float(value) * UNITS[parameter.unit][1]
        else:
            converted[name] = value
    return converted


def perform(
    scenario: Scenario, seed: int, overrides: Mapping[str, Value] | None = None
) -> Performance:
    """The concrete sequence of a seed. Raises BenchError for what cannot be played."""
    if seed < 0:
        raise BenchError(f"seed must be 0 or more, got {seed}")
    overrides = dict(overrides or {})
    values = in_si(scenario, concrete(scenario, seed, overrides))
    scene = scene_of(scenario, values)
    fps = _setting(scenario, overrides, "fps")
    frames = int(_setting(scenario, overrides, "frames"))
    stage = Stage(
        scene=scene,
        values=values,
        streams=lambda name: generator(seed, f"{scenario.family}/motion/{name}"),
        duration_s=max(frames / fps, 1.0),
    )
    script = Performer(scene, GESTURES[scenario.motion.kind].plan(stage))
    # The seed is judged here, not in the middle of a sequence: frames at 3 per second or fewer.
    for t_s in np.arange(0.0, frames / fps, 1 / min(fps, 3.0)).tolist():
        script.body(t_s)
    return Performance(
        scene=scene,
        script=script,
        frames=frames,
        fps=fps,
        background_frames=int(_setting(scenario, overrides, "background_frames")),
        seed=seed,
    )


class Entry(Record):
    """One line of a suite: a scenario, and what to change of it."""

    scenario: Text
    frames: Annotated[Whole, Field(ge=1, le=MAX_FRAMES)] | None = None
    seeds: Annotated[Whole, Field(ge=1, le=100_000)] | None = None
    overrides: dict[Name, Annotated[float, Strict()] | Text] = {}


class Suite(Record):
    """An ordered list of scenarios. `seeds`: how many each plays unless its entry says."""

    name: Name
    version: Annotated[Whole, Field(ge=1)] = 1
    summary: Text
    seeds: Annotated[Whole, Field(ge=1, le=100_000)] = 1
    scenarios: Annotated[tuple[Entry, ...], Field(min_length=1)]


def suite_digest(suite: Suite, scenarios: Mapping[str, Scenario]) -> str:
    """SHA-256 of a suite and of the scenarios (by name) that it lists, hexadecimal."""
    parts = [canonical(suite), *(digest(scenarios[e.scenario]) for e in suite.scenarios)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


__all__ = [
    "STANDARD",
    "Choice",
    "Entry",
    "Numeric",
    "Scenario",
    "Suite",
    "canonical",
    "concrete",
    "digest",
    "draw",
    "latent",
    "perform",
    "quantity",
    "suite_digest",
]
