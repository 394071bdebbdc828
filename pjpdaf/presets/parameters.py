"""Frozen parameters of detector and tracker, each with unit and source, and the presets.

SI inside. The thesis prints Table 4.1 without units; plots are in mm and the numbers fit mm and
frames (3 frames/s, dt = 1 frame), so a variance of v mm^2 is v * 1e-6 m^2 and a velocity variance
of v (mm/frame)^2 is v * 1e-6 * 3^2 (m/s)^2.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from pjpdaf.errors import BenchError

FRAME_S = 1.0 / 3.0  # one thesis frame [s], section 4.1
MM2 = 1e-6  # 1 mm^2 in m^2
MM2_PER_FRAME2 = 1e-6 / FRAME_S**2  # 1 (mm/frame)^2 in (m/s)^2


class UnknownPreset(BenchError):
    """No preset of that name."""

    def __init__(self, name: str, known: Collection[str]) -> None:
        super().__init__(f"No preset {name!r}.{did_you_mean(name, known)}")


class BadParameter(BenchError):
    """A parameter out of its range, or a KEY=VALUE that names none or does not fit."""


def did_you_mean(name: str, known: Collection[str]) -> str:
    """' Did you mean ...? Known: ...' for an error message."""
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    return f"{hint} Known: {', '.join(sorted(known))}."


def _positive(record: Any, names: tuple[str, ...], zero: bool = False) -> None:
    for name in names:
        value = getattr(record, name)
        if not (math.isfinite(value) and (value > 0 or (zero and value == 0))):
            rule = "at least 0" if zero else "above 0"
            raise BadParameter(f"{type(record).__name__}.{name} must be {rule}, got {value!r}.")


@dataclass(frozen=True)
class DetectorParameters:
    """Thesis 3.1: skin, background, blobs, k-means."""

    # What is undistorted: the centres only ('points', cheap, exact) or the picture ('picture', the
    # thesis: Calibration Toolbox, section 4.1).
    undistort: Literal["points", "picture"] = "points"
    # Hue interval [deg], min..max upwards; may wrap: (350, 20) crosses 0. "Determined empirically".
    hue_range_deg: tuple[float, float] = (2.0, 40.0)
    # Saturation interval [1], 0..1. "Determined empirically".
    saturation_range: tuple[float, float] = (0.2, 0.7)
    # Smallest value (brightness) of a skin pixel [1], 0..1. Not in the thesis: dark hair is noise.
    value_min: float = 0.2
    # Fewest person-free frames to learn the background from [frames]. Thesis: "several".
    background_learn_min: int = 10
    # Squared Mahalanobis distance above which a pixel is foreground [1]. Not printed;
    # 16.27 is the 99.9 % point of chi-square with 3 degrees of freedom.
    background_threshold: float = 16.27
    # Floors of the background's standard deviations: hue [deg], saturation and value [1].
    hue_sd_floor_deg: float = 6.0
    sat_sd_floor: float = 0.03
    val_sd_floor: float = 0.03
    # A pixel that only lost light is shadow, not foreground: its value lies between this share of
    # the background's and all of it [1], and hue and saturation pass the test alone. 1 = no such
    # rule, as in the thesis. The person's own shadow on wood keeps the hue of skin.
    shadow_min: float = 0.5
    # Smallest component kept [px], A_min of Table 4.1 (500), here at the reference focal length.
    min_area_px: float = 150.0
    # min_area_px holds for this focal length [px] and this depth [m]; it is scaled by
    # (f / reference_focal_px)^2 (and by (reference_depth_m / Z)^2 where a depth Z is known).
    # 0 = unscaled, as in the thesis.
    reference_focal_px: float = 540.0
    reference_depth_m: float = 1.3
    # Diameter of the opening and closing elements [px]; 0 = none. "Combination of operations".
    open_px: int = 3
    close_px: int = 5
    # p of Eq. 3.2 [1], Table 4.1.
    kmeans_penalty: float = 5.0
    # Hypotheses k = 1 .. N + extra_hypotheses clusters, section 3.1.2.
    extra_hypotheses: int = 2
    # k-means sees every n-th skin pixel [1]; 1 = all, as in the thesis.
    subsample: int = 16
    # Standard deviation of a centre, per axis [px], reported with each detection; R of Table 4.1
    # is 15 px^2.
    centre_sd_px: float = math.sqrt(15.0)
    # A component under min_area_px joins the nearest one if that is nearer than its own diameter
    # (a sleeve, a cup or a shadow cut it off). Not in the thesis.
    merge_fragments: bool = True
    # The N components themselves compete, beside k-means with k = N: k-means alone gives the rim of
    # a head to a hand close by. Not in the thesis.
    components_compete: bool = True

    def __post_init__(self) -> None:
        _positive(
            self,
            (
                "background_threshold",
                "hue_sd_floor_deg",
                "sat_sd_floor",
                "val_sd_floor",
                "kmeans_penalty",
                "centre_sd_px",
                "background_learn_min",
                "subsample",
            ),
        )
        _positive(
            self,
            (
                "value_min",
                "shadow_min",
                "min_area_px",
                "reference_focal_px",
                "reference_depth_m",
                "open_px",
                "close_px",
                "extra_hypotheses",
            ),
            zero=True,
        )
        low, high = self.saturation_range
        if not 0 <= low < high <= 1:
            raise BadParameter(
                "DetectorParameters.saturation_range must be min < max within 0..1, "
                f"got {self.saturation_range}."
            )


Measurement = Literal["thesis", "centred", "jacobian"]
Clutter = Literal["density", "relative", "area"]
Update = Literal[
    "stacked", "stacked_detected", "stacked_weighted", "sequential", "fused", "most_probable"
]


@dataclass(frozen=True)
class TrackerParameters:
    """Thesis 3.2-3.6 and Table 4.1, plus the readings of what the thesis leaves open.

    measurement, the matrix H of Eq. 3.20: 'thesis' lambda M; 'centred' the same with the pixel
    origin at the principal point; 'jacobian' the derivative of the projection.
    clutter_reading, C of Eq. 3.32: 'density' C [1/px^2] beside a Gaussian density; 'relative' C
    relative to the Gaussian's peak (N becomes exp(-d^2/2)); 'area' C false blobs an image, divided
    by the image's area.
    update: 'stacked' Eq. 3.39-3.44 as printed; 'stacked_detected' the same without the views in
    which the gate is empty; 'stacked_weighted' each view's noise divided by its 1 - beta_0n;
    'sequential' each view's own PDA update in turn; 'fused' each view's own PDA update of the
    prediction, their information added up; 'most_probable' the likeliest measurement of each view,
    taken as certain, in an ordinary Kalman update (Eq. 3.10-3.12).
    beta_0 (Eq. 3.42): 'sum' as printed; 'product' what its words say.
    occlusion (Eq. 3.23), the views left out for a target: 'shared_measurement' a measurement lies
    in two targets' gates; 'fewer_measurements' a cluster of gates holds fewer measurements than
    targets; 'none'.
    process: 'per_frame' the same Q every step; 'scaled' Q * dt / frame_s.
    """

    measurement: Measurement = "jacobian"
    clutter_reading: Clutter = "relative"
    update: Update = "fused"
    beta_0: Literal["sum", "product"] = "product"
    occlusion: Literal["shared_measurement", "fewer_measurements", "none"] = "fewer_measurements"
    process: Literal["per_frame", "scaled"] = "scaled"
    # One frame, the unit of time of the thesis's velocities and of Q [s]; 3 frames/s, section 4.1.
    frame_s: float = FRAME_S
    # P_0 of Table 4.1, per axis: 70 mm^2 [m^2] and 30 (mm/frame)^2 [(m/s)^2].
    start_position_m2: float = 70 * MM2
    start_velocity_m2ps2: float = 30 * MM2_PER_FRAME2
    # Q of Table 4.1 a frame, per axis: 50 mm^2 [m^2] and 5 (mm/frame)^2 [(m/s)^2].
    process_position_m2: float = 50 * MM2
    process_velocity_m2ps2: float = 5 * MM2_PER_FRAME2
    # R of Table 4.1, per axis [px^2].
    measurement_px2: float = 15.0
    # R's third entry [1]: the variance of the constant third row; 0 = the row is left out.
    third_row_variance: float = 0.0
    # P_D of Table 4.1 [1].
    p_detect: float = 0.9
    # g^2 of Table 4.1 [1].
    gate: float = 15.0
    # C of Table 4.1; its unit is that of clutter_reading.
    clutter: float = 0.1
    # A target is found in a view where the mass 1 - beta_0n is at least this [1]. Ours.
    found_mass: float = 0.5
    # Lost after this time without being found in two views [s], or at this standard deviation of
    # the position along its worst axis [m]. Ours.
    lost_after_s: float = 1.0
    lost_sd_m: float = 0.5
    # Start (section 3.6) only where every target triangulates within this distance in each view
    # [px], this depth [m], and the hands within this distance of the head [m]. Ours.
    start_residual_px: float = 10.0
    start_depth_m: tuple[float, float] = (0.3, 5.0)
    start_reach_m: float = 1.2

    def __post_init__(self) -> None:
        _positive(
            self,
            (
                "frame_s",
                "start_position_m2",
                "start_velocity_m2ps2",
                "measurement_px2",
                "gate",
                "clutter",
                "lost_sd_m",
                "start_residual_px",
                "start_reach_m",
            ),
        )
        _positive(
            self,
            (
                "process_position_m2",
                "process_velocity_m2ps2",
                "third_row_variance",
                "lost_after_s",
            ),
            zero=True,
        )
        for name in ("p_detect", "found_mass"):
            if not 0 < getattr(self, name) < 1:
                value = getattr(self, name)
                raise BadParameter(
                    f"TrackerParameters.{name} must be between 0 and 1, got {value!r}."
                )
        if self.clutter_reading == "area" and self.third_row_variance:
            raise BadParameter(
                "TrackerParameters.clutter_reading 'area' is a density over x and y; "
                "set third_row_variance=0 with it."
            )


@dataclass(frozen=True)
class Departure:
    """One place where a preset leaves the printed thesis."""

    name: str
    thesis: str
    ours: str
    reason: str
    effect: str


@dataclass(frozen=True)
class Preset:
    """A named pair of parameter records and the departures they stand for."""

    name: str
    detector: DetectorParameters
    tracker: TrackerParameters
    departures: tuple[Departure, ...]


# Effects are measured on rendered pictures (docs/algorithm.md has the set-up and the whole table):
# the share of target-frames within 100 mm, mean of five scenarios of 10 tuning seeds each, with all
# other fields as in 'thesis', which has 94.4 %.
_DIMENSION = Departure(
    "exponent of 2 pi",
    "(2 pi)^{m/2}, m the number of measurements (Eq. 3.32)",
    "the dimension of one measurement",
    "as printed, the weight of a measurement would depend on how many others there are",
    "none where a view has as many measurements as one measurement has rows",
)
_INFINITY = Departure(
    "infinite measurement noise",
    "R = infinity in a view with an occlusion (Eq. 3.23)",
    "the view's rows are left out of z, H and S",
    "the limit of Eq. 3.12 for R to infinity, without dividing by it",
    "none",
)
_WAIT = Departure(
    "start",
    "the first frame (section 3.6)",
    "the first frame whose views agree: residual, depth, distance between head and hands",
    "in 0-15 % of sequences a hand is hidden, or too small in one view, when the action starts",
    "a later start instead of a wrong one",
)
_COMMON = (_DIMENSION, _INFINITY, _WAIT)
_TINY_FLOORS = Departure(
    "floors of the background's deviations",
    "none (section 3.1.1)",
    "about one step of 8-bit HSV",
    "a pixel that never changed has variance 0, and then every pixel is foreground",
    "makes the printed method computable",
)

_LITERAL = Preset(
    "thesis-literal",
    DetectorParameters(
        undistort="picture",
        value_min=0.0,
        hue_sd_floor_deg=2.0,
        sat_sd_floor=1 / 255,
        val_sd_floor=1 / 255,
        shadow_min=1.0,
        min_area_px=500.0,
        reference_focal_px=0.0,
        reference_depth_m=0.0,
        subsample=1,
        merge_fragments=False,
        components_compete=False,
    ),
    TrackerParameters(
        measurement="thesis",
        clutter_reading="density",
        update="stacked",
        beta_0="sum",
        occlusion="shared_measurement",
        process="per_frame",
        third_row_variance=0.5,
    ),
    (*_COMMON, _TINY_FLOORS),
)

# The thesis preset: the same structure in the reading that works.
_THESIS = Preset(
    "thesis",
    DetectorParameters(
        min_area_px=500.0, reference_focal_px=0.0, reference_depth_m=0.0, merge_fragments=False
    ),
    TrackerParameters(
        process_position_m2=64 * 50 * MM2,
        process_velocity_m2ps2=0.0,
    ),
    (
        *_COMMON,
        Departure(
            "measurement matrix",
            "H = lambda M (Eq. 3.20-3.21)",
            "the Jacobian of the projection (`measurement`)",
            "lambda M lacks -z M^3, so in a parallel rig depth is corrected wrongly or, with the "
            "pixel origin at the principal point, never",
            "87.8 % with lambda M; every crossing swapped",
        ),
        Departure(
            "third row",
            "the constant 1 with variance 0.5 (Eq. 3.19, Table 4.1)",
            "left out (`third_row_variance` 0)",
            "it carries no information: its innovation is always 0",
            "none measurable",
        ),
        Departure(
            "clutter",
            "C = 0.1 beside a Gaussian density (Eq. 3.32)",
            "C relative to the Gaussian's peak (`clutter_reading`)",
            "as a density, 0.1 false blobs per px^2 outweigh a perfect hit, and the filter freezes",
            "73.5 % with the density; 94.9 % with 0.2 false blobs an image instead",
        ),
        Departure(
            "update",
            "all views in one stacked update (Eq. 3.39-3.44); its beta_0 is the sum over the views "
            "(Eq. 3.42, `beta_0`)",
            "Eq. 3.10, 3.12, 3.41, 3.43-3.44 for each view apart, their information added up "
            "(`update`); where views are stacked, `beta_0` is the product, as the words around "
            "Eq. 3.42 say",
            "stacked, a view without a detection counts as an innovation of 0 at full gain, and "
            "the sum exceeds 1",
            "93.7 % stacked with the product, 93.9 % with the sum; on points with 15 % misses 13 "
            "and 23 of 24 crossings end lost, not 1",
        ),
        Departure(
            "occlusion",
            "a measurement in two targets' gates (section 3.3.2)",
            "a cluster of gates with fewer measurements than targets, pairs with a weight of 0.9 "
            "or more apart (`occlusion`)",
            "no update makes gates larger, and larger gates overlap more: as printed the rule "
            "deadlocks",
            "78.4 % as printed, 87.7 % without a rule",
        ),
        Departure(
            "process noise",
            "diag(50 50 50 0 5 5 5 0) in mm^2 and frames (Table 4.1)",
            "64 times the position's, none for the velocity (`process_position_m2`, "
            "`process_velocity_m2ps2`)",
            "at 3 frames a second the printed noise follows hands slower than about 0.2 m/s; a "
            "velocity that learns from one frame carries a hand that stops inside a merged blob "
            "past the face or through the other hand",
            "75.9 % as printed, 84.2 % with both times 16; drink is kept in 0 and 0 of 10 runs, "
            "not 10; with a learning velocity more crossings are kept (7 of 10, not 4) and fewer "
            "bounces (3 of 10, not 10)",
        ),
        Departure(
            "frame rate",
            "one Q a frame, at 3 frames a second (section 4.1)",
            "Q * dt / frame_s (`process`)",
            "the same hands at another frame rate move less, or more, between frames",
            "none at 3 frames a second",
        ),
        Departure(
            "background deviations",
            "none (section 3.1.1)",
            "floors of 6 deg and 0.03 (`hue_sd_floor_deg`, `sat_sd_floor`, `val_sd_floor`)",
            "a few frames underestimate the deviation of a quiet pixel",
            "fewer false foreground pixels",
        ),
        Departure(
            "shadows",
            "none (section 3.1.1)",
            "a pixel that only lost light, down to half, is background (`shadow_min`)",
            "the person's own shadow on wood keeps the hue of skin",
            "fewer false blobs on the table",
        ),
        Departure(
            "dark pixels",
            "skin by hue and saturation alone (section 3.1.1)",
            "and a value above 0.2 (`value_min`)",
            "the hue of dark hair is noise",
            "without it the head's blob grows 1.5 times",
        ),
        Departure(
            "undistortion",
            "of the whole picture (section 4.1)",
            "of the centres found in it (`undistort`)",
            "the same numbers for a fraction of the time",
            "none measurable",
        ),
        Departure(
            "k-means pixels",
            "all skin pixels (section 3.1.2)",
            "every 16th (`subsample`)",
            "the same number of clusters",
            "2.4 ms instead of 28-63 ms a picture",
        ),
        Departure(
            "components as a hypothesis",
            "k-means alone, k = 1 .. N + 2 (section 3.1.2)",
            "the N components themselves compete with them (`components_compete`)",
            "k-means divides space halfway between centres, and so gives the rim of a head to a "
            "hand close by; the head is then cut up",
            "three blobs in 100 % instead of 28 % of drawn scenes with a hand 15 px from the head",
        ),
    ),
)

PRESETS: dict[str, Preset] = {preset.name: preset for preset in (_LITERAL, _THESIS)}


def find_preset(name: str) -> Preset:
    """The preset of that name. Raises UnknownPreset."""
    if name not in PRESETS:
        raise UnknownPreset(name, PRESETS)
    return PRESETS[name]


def field_names(record: type) -> tuple[str, ...]:
    """Names of a parameter record's fields, in order."""
    return tuple(field.name for field in dataclasses.fields(record))


Parameters = TypeVar("Parameters", DetectorParameters, TrackerParameters)


def with_values(record: Parameters, values: Mapping[str, object]) -> Parameters:
    """A copy with some fields changed; texts are read as the field's type. Raises BadParameter."""
    kinds = get_type_hints(type(record))
    changed = {}
    for key, value in values.items():
        if key not in kinds:
            raise BadParameter(
                f"{type(record).__name__} has no field {key!r}.{did_you_mean(key, kinds)}"
            )
        changed[key] = _read(key, value, kinds[key])
    return dataclasses.replace(record, **changed)


def override(preset: Preset, values: Mapping[str, object]) -> Preset:
    """A preset with KEY=VALUE changes, e.g. {'p_detect': '0.8', 'detector.min_area_px': '150'}.

    A key is a field of either record, or starts with 'detector.' or 'tracker.'. Raises
    BadParameter with the choices and the nearest name.
    """
    parts: dict[str, dict[str, object]] = {"detector": {}, "tracker": {}}
    names = {
        "detector": field_names(DetectorParameters),
        "tracker": field_names(TrackerParameters),
    }
    for key, value in values.items():
        part, _, name = key.rpartition(".")
        homes = [part] if part in parts else [home for home in parts if not part]
        home = next((home for home in homes if name in names[home]), None)
        if home is None:
            known = [field for h in (homes or list(parts)) for field in names[h]]
            raise BadParameter(f"No parameter {key!r}.{did_you_mean(name, known)}")
        parts[home][name] = value
    return dataclasses.replace(
        preset,
        detector=with_values(preset.detector, parts["detector"]),
        tracker=with_values(preset.tracker, parts["tracker"]),
    )


_TRUE, _FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def _read(key: str, value: object, kind: Any) -> Any:
    """`value`, possibly text, as `kind`: Literal, bool, int, float or a tuple of floats."""
    origin = get_origin(kind)
    if origin is Literal:
        if value in get_args(kind):
            return value
        raise BadParameter(
            f"{key} must be one of {', '.join(map(repr, get_args(kind)))}, got {value!r}."
        )
    if origin is tuple:
        parts = value.strip("()[] ").split(",") if isinstance(value, str) else value
        wanted = get_args(kind)
        if not isinstance(parts, (list, tuple)) or len(parts) != len(wanted):
            raise BadParameter(
                f"{key} must be {len(wanted)} numbers with commas between, got {value!r}."
            )
        return tuple(_read(key, part, k) for part, k in zip(parts, wanted, strict=True))
    if kind is bool:
        text = str(value).strip().lower()
        if text not in _TRUE + _FALSE:
            raise BadParameter(f"{key} must be true or false, got {value!r}.")
        return text in _TRUE
    assert kind in (int, float), kind
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise BadParameter(f"{key} must be a number, got {value!r}.")
    try:
        number = kind(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or (kind is int and float(value) != number):
        noun = "a whole number" if kind is int else "a number"
        raise BadParameter(f"{key} must be {noun}, got {value!r}.")
    return number
