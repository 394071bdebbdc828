"""Skin colour in HSV (thesis 3.1.1): the mask, and learning its range from samples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.checks import BadParameter, NotNegative, check_bounds
from pjpdaf.errors import BenchError

HUE_STEP_DEG = 360.0 / 256.0  # OpenCV's "full" HSV: hue 0..255 is one turn, s and v are 0..255
LEARN_MIN_PX = 50  # fewer sample pixels do not show the tails of a distribution
MARGIN_HUE_DEG = 4.0  # added to a learnt range, for a hand in other light than the sample
MARGIN_SATURATION = 0.05


@dataclass(frozen=True)
class SkinRange:
    """Box in HSV that skin lies in (Hmin, Hmax, Smin, Smax of section 3.1.1, and Vmin).

    The defaults were determined empirically, as the thesis says.
    """

    # Hue interval [deg], from..to upwards; may wrap: (350, 20) crosses 0.
    hue_range_deg: tuple[float, float] = (2.0, 40.0)
    # Saturation interval [1], 0..1.
    saturation_range: tuple[float, float] = (0.2, 0.7)
    # Smallest value (brightness) of a skin pixel [1], 0..1. Not in the thesis: hue and saturation
    # of dark hair are noise.
    value_min: NotNegative = 0.2

    def __post_init__(self) -> None:
        check_bounds("DetectorParameters", self)
        low, high = self.saturation_range
        if not 0 <= low < high <= 1:
            raise BadParameter(
                "DetectorParameters.saturation_range must be min < max within 0..1, "
                f"got {self.saturation_range}."
            )

    @property
    def hue_span_deg(self) -> float:
        """Width of the hue interval, 0..360."""
        low, high = self.hue_range_deg
        return 360.0 if high - low >= 360.0 else (high - low) % 360.0


def to_hsv(picture: np.ndarray) -> np.ndarray:
    """uint8 BGR (h, w, 3) to uint8 HSV (h, w, 3): hue in steps of 360/256 deg, s and v 0..255."""
    hsv: np.ndarray = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL)
    return hsv


def skin_mask(hsv: np.ndarray, skin: SkinRange) -> np.ndarray:
    """Pixels of `hsv` (h, w, 3), as of `to_hsv`, inside the range: uint8 (h, w), 255 = skin."""
    low_s = math.ceil(skin.saturation_range[0] * 255 - 1e-9)
    high_s = math.floor(skin.saturation_range[1] * 255 + 1e-9)
    low_v = math.ceil(skin.value_min * 255 - 1e-9)
    mask: np.ndarray | None = None
    for low_h, high_h in _hue_intervals(skin):
        inside = cv2.inRange(hsv, (low_h, low_s, low_v), (high_h, high_s, 255))
        mask = inside if mask is None else cv2.bitwise_or(mask, inside)
    return np.zeros(hsv.shape[:2], np.uint8) if mask is None else mask


def _hue_intervals(skin: SkinRange) -> list[tuple[int, int]]:
    """Split the range into one or two intervals of whole hue steps within 0..255."""
    if skin.hue_span_deg >= 360.0:
        return [(0, 255)]
    # A rounding guard: 90 deg is exactly step 64 and must be inside (90, 100).
    first = math.ceil(skin.hue_range_deg[0] / HUE_STEP_DEG - 1e-9)
    last = math.floor((skin.hue_range_deg[0] + skin.hue_span_deg) / HUE_STEP_DEG + 1e-9)
    turns = first // 256
    first, last = first - 256 * turns, last - 256 * turns
    if last < first:
        return []
    return [(first, last)] if last < 256 else [(first, 255), (0, last - 256)]


def circular_mean_deg(hue_deg: Floats) -> float:
    """Mean direction of angles (n,) [deg], in 0..360."""
    radians = np.radians(hue_deg)
    mean = math.atan2(float(np.sin(radians).mean()), float(np.cos(radians).mean()))
    # The second remainder: the first rounds a mean of -1e-16 up to 360 itself.
    return math.degrees(mean) % 360.0 % 360.0


def circular_difference_deg(a: Floats, b: Floats | float) -> Floats:
    """a - b on the circle, in [-180, 180) [deg]."""
    return np.asarray((a - b + 180.0) % 360.0 - 180.0)


def learn_skin_range(
    samples: np.ndarray, mask: np.ndarray | None = None, percentile: float = 1.0
) -> SkinRange:
    """Skin range from a sample picture, thesis 3.1.1 ("values determined empirically").

    samples: uint8 BGR (h, w, 3), a picture cropped to skin, or a whole picture with `mask` (h, w),
    non-zero on skin. The range leaves `percentile` per cent out at either end, widened by a margin.

    Raises BenchError where fewer than 50 pixels are left.
    """
    if samples.dtype != np.uint8 or samples.ndim != 3 or samples.shape[2] != 3:
        raise BenchError(
            "A skin sample must be a uint8 BGR picture (h, w, 3), "
            f"got {samples.dtype} {samples.shape}."
        )
    if mask is not None and mask.shape != samples.shape[:2]:
        raise BenchError(
            f"The mask of a skin sample must have the picture's size {samples.shape[:2]}, "
            f"got {mask.shape}."
        )
    pixels = to_hsv(samples).reshape(-1, 3)
    if mask is not None:
        pixels = pixels[np.asarray(mask).ravel() != 0]
    pixels = pixels[(pixels[:, 1] > 0) & (pixels[:, 2] > 0)]  # grey has no hue
    if len(pixels) < LEARN_MIN_PX:
        raise BenchError(
            f"A skin sample needs at least {LEARN_MIN_PX} coloured pixels, got {len(pixels)}: "
            "give a larger picture or mask."
        )
    ends = [percentile, 100.0 - percentile]
    hue = pixels[:, 0] * HUE_STEP_DEG
    centre = circular_mean_deg(hue)
    from_centre = np.percentile(circular_difference_deg(hue, centre), ends)
    low_s, high_s = np.percentile(pixels[:, 1] / 255.0, ends)
    low_v = float(np.percentile(pixels[:, 2] / 255.0, percentile))
    return SkinRange(
        (
            float((centre + from_centre[0] - MARGIN_HUE_DEG) % 360.0),
            float((centre + from_centre[1] + MARGIN_HUE_DEG) % 360.0),
        ),
        (
            float(max(0.0, low_s - MARGIN_SATURATION)),
            float(min(1.0, high_s + MARGIN_SATURATION)),
        ),
        0.6 * low_v,  # a hand in the body's shadow is darker than the sample
    )


def learn_skin_from_head(
    pictures: Iterable[np.ndarray],
    broad: SkinRange,
    foreground: Iterable[np.ndarray] | None = None,
    min_area_px: float = 500.0,
) -> SkinRange:
    """Skin range from the head region of the first frames (thesis 3.6: the head is the top blob).

    pictures: uint8 BGR (h, w, 3); broad: a range wide enough for anyone, in which the highest
    component of at least min_area_px is taken to be the head; foreground: per picture a mask
    (h, w), non-zero where the scene differs from the background.

    Raises BenchError where no picture shows such a region.
    """
    masks = iter(foreground) if foreground is not None else None
    skin = []
    for picture in pictures:
        region = skin_mask(to_hsv(picture), broad)
        if masks is not None:
            region = np.where(next(masks) != 0, region, np.uint8(0))
        region = cv2.morphologyEx(region, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        count, labels, stats, _ = cv2.connectedComponentsWithStats(region, connectivity=8)
        large = [i for i in range(1, count) if stats[i, cv2.CC_STAT_AREA] >= min_area_px]
        if not large:
            continue
        head = min(large, key=lambda i: int(stats[i, cv2.CC_STAT_TOP]))
        # The rim mixes with hair and wall.
        inside = cv2.erode((labels == head).astype(np.uint8), np.ones((5, 5), np.uint8))
        skin.append(picture[inside != 0])
    if not skin:
        raise BenchError(
            f"No region of at least {min_area_px:g} px in the broad skin range was found in the "
            "first frames: give a sample of the skin instead."
        )
    return learn_skin_range(np.concatenate(skin)[None])
