"""Frozen parameters of detector and tracker, each with unit and source, and the presets.

SI inside. The thesis prints Table 4.1 without units; plots are in mm and the numbers fit mm and
frames (3 frames/s, dt = 1 frame), so a variance of v mm^2 is v * 1e-6 m^2 and a velocity variance
of v (mm/frame)^2 is v * 1e-6 * 3^2 (m/s)^2.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from pjpdaf.errors import BenchError

FRAME_S = 1.0 / 3.0  # one thesis frame [s], section 4.1
MM2 = 1e-6  # 1 mm^2 in m^2
MM2_PER_FRAME2 = 1e-6 / FRAME_S**2  # 1 (mm/frame)^2 in (m/s)^2


class UnknownPreset(BenchError):
    """No preset of that name."""

    def __init__(self, name: str, known: Collection[str]) -> None:
        super().__init__(f"No preset {name!r}.{did_you_mean(name, known)}")


class BadOverride(BenchError):
    """A KEY=VALUE that names no parameter, or whose value does not fit it."""


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
            raise BadOverride(f"{type(record).__name__}.{name} must be {rule}, got {value!r}.")


@dataclass(frozen=True)
class DetectorParameters:
    """Thesis 3.1: skin, background, blobs, k-means."""

    # What is undistorted: the centres only ('points', cheap, exact) or the picture ('picture', the
    # thesis: Calibration Toolbox, section 4.1).
    undistort: Literal["points", "picture"] = "points"
    # Hue interval [deg], min..max upwards; may wrap: (350, 20) crosses 0. "Determined empirically".
    hue_range_deg: tuple[float, float] = (2.0, 38.0)
    # Saturation interval [1], 0..1. "Determined empirically".
    saturation_range: tuple[float, float] = (0.25, 0.65)
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
    # Components nearer than their own size are one object (a sleeve, a cup or a shadow cut it).
    merge_fragments: bool = True

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
            raise BadOverride(
                "DetectorParameters.saturation_range must be min < max within 0..1, "
                f"got {self.saturation_range}."
            )
