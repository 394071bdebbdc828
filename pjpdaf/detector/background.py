"""Background: a Gaussian over (H, S, V) for each pixel, thesis 3.1.1."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import readonly
from pjpdaf.checks import AboveZero, AboveZeroInt, NotNegative, check_bounds
from pjpdaf.detector.skin import HUE_STEP_DEG, to_hsv
from pjpdaf.errors import BenchError

UNIFORM_SD_DEG = 360.0 / 12**0.5  # of a hue distributed uniformly, as a grey pixel's


@dataclass(frozen=True)
class BackgroundParameters:
    """Learning of the background, and the test of a pixel against it."""

    # Fewest person-free frames to learn the background from [frames]. Thesis: "several".
    background_learn_min: AboveZeroInt = 10
    # Foreground where d^2 = sum (x - mean)^2 / sd^2 is above this [1]. Not printed;
    # 16.27 is the 99.9 % point of chi-square with 3 degrees of freedom.
    background_threshold: AboveZero = 16.27
    # Floors of the background's standard deviations: hue [deg], saturation and value [1].
    hue_sd_floor_deg: AboveZero = 6.0
    sat_sd_floor: AboveZero = 0.03
    val_sd_floor: AboveZero = 0.03
    # A pixel that only lost light is shadow, not foreground: its value lies between this share of
    # the background's and all of it [1], and hue and saturation pass the test alone. 1 = no such
    # rule, as in the thesis. The person's own shadow on wood keeps the hue of skin.
    shadow_min: NotNegative = 0.5

    def __post_init__(self) -> None:
        check_bounds("DetectorParameters", self)


@dataclass(frozen=True, eq=False)
class Background:
    """Mean and standard deviation of each pixel of a person-free scene.

    mean, sd: float32 (h, w, 3): hue [deg] (circular), saturation and value in 0..1, as observed,
    without floors; frames: number of pictures they come from.
    """

    mean: np.ndarray
    sd: np.ndarray
    frames: int

    def __post_init__(self) -> None:
        for name in ("mean", "sd"):
            value = readonly(getattr(self, name), (None, None, 3), f"Background.{name}", np.float32)
            object.__setattr__(self, name, value)
        if self.mean.shape != self.sd.shape:
            raise ValueError(
                f"Background.sd must have the shape of mean {self.mean.shape}, got {self.sd.shape}"
            )

    @property
    def bgr(self) -> np.ndarray:
        """The mean as BGR, float32 (h, w, 3), 0-255."""
        hsv = np.ascontiguousarray(self.mean)
        return np.asarray(cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR) * 255.0)


@dataclass(frozen=True, eq=False)
class BackgroundTest:
    """A background made ready for the test of a pixel.

    mean (3, h*w) float32 in the units of `to_hsv`; precision (3, h*w) float32: 1 / variance of a
    new observation in these units; threshold: squared Mahalanobis distance of the foreground;
    shadow_min: smallest share of the background's value that a shadow leaves, 1 = no shadows.
    """

    mean: np.ndarray
    precision: np.ndarray
    threshold: float
    shadow_min: float


class BackgroundSums:
    """Sums over the pictures learnt so far; memory stays flat."""

    def __init__(self) -> None:
        self.frames = 0
        self._size: tuple[int, ...] = ()
        angles = np.arange(256) * (2 * np.pi / 256)
        self._directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)[None]

    def add(self, picture: np.ndarray) -> None:
        """Add a person-free picture, uint8 BGR (h, w, 3). Raises BenchError for another size."""
        if self.frames == 0:
            self._size = picture.shape
            self._direction = np.zeros((*picture.shape[:2], 2))  # sums of the hue's cosine and sine
            self._first = np.zeros(picture.shape)  # sums of H, S and V, whole numbers
            self._second = np.zeros(picture.shape)  # sums of their squares
        elif picture.shape != self._size:
            raise BenchError(
                f"Background pictures must have one size, got {self._size[1]}x{self._size[0]} "
                f"and {picture.shape[1]}x{picture.shape[0]}."
            )
        hsv = to_hsv(picture)
        hue = hsv[..., 0]
        self._direction += cv2.LUT(cv2.merge([hue, hue]), self._directions)
        cv2.accumulate(hsv, self._first)
        cv2.accumulateSquare(hsv, self._second)
        self.frames += 1

    def result(self, frames_min: int) -> Background:
        """Return the background. Raises BenchError for fewer than frames_min pictures."""
        n = self.frames
        if n < max(frames_min, 2):
            raise BenchError(
                f"The background needs at least {max(frames_min, 2)} person-free frames, got {n}: "
                "record more, or lower background_learn_min (10 frames give 2.8 % false "
                "foreground, 3 give 14.5 %)."
            )
        mean, sd = np.empty(self._size), np.empty(self._size)
        c, s = self._direction[..., 0], self._direction[..., 1]
        R = np.clip(np.hypot(c, s) / n, 1e-12, 1.0)
        mean[..., 0] = np.degrees(np.arctan2(s, c)) % 360.0
        # n / (n - 1), as for any variance from n values; exact for the small spreads that matter.
        variance_deg2 = np.degrees(1.0) ** 2 * -2.0 * np.log(R) * n / (n - 1)
        sd[..., 0] = np.minimum(np.sqrt(variance_deg2), UNIFORM_SD_DEG)
        first, second = self._first[..., 1:], self._second[..., 1:]
        mean[..., 1:] = first / n / 255.0
        spread = np.maximum(second - first * first / n, 0.0) / (n - 1)
        sd[..., 1:] = np.sqrt(spread) / 255.0
        return Background(mean, sd, n)


def prepare(background: Background, parameters: BackgroundParameters) -> BackgroundTest:
    """Prepare the test of a background, with floors under its standard deviations.

    The variance of a new observation, given mean and variance from n, is that of Student's t:
    s^2 (1 + 1/n) (n - 1) / (n - 3); for n = 10 that is 1.41 s^2. Floors come after.
    """
    p = parameters
    n = background.frames
    inflation = (1 + 1 / n) * (n - 1) / max(n - 3, 1)
    floors = np.array([p.hue_sd_floor_deg, p.sat_sd_floor, p.val_sd_floor], np.float32)
    steps = np.array([HUE_STEP_DEG, 1 / 255, 1 / 255], np.float32)
    sd = np.maximum(background.sd * np.float32(inflation**0.5), floors) / steps
    return BackgroundTest(
        _planes(background.mean / steps, "mean"),
        _planes(1 / (sd * sd), "precision"),
        p.background_threshold,
        p.shadow_min,
    )


def _planes(values: np.ndarray, name: str) -> np.ndarray:
    """Channels (3, h*w) of values (h, w, 3): numpy works slowly along an axis of 3."""
    channels = np.ascontiguousarray(values.reshape(-1, 3).T)
    return readonly(channels, (3, None), name, np.float32)


def is_foreground(
    test: BackgroundTest, hsv: np.ndarray, at: np.ndarray | None = None
) -> np.ndarray:
    """Test the pixels `at` (n,), flat indices into hsv (h, w, 3), or all: bool (n,), foreground.

    Foreground is d^2 = sum (x - mean)^2 / sd^2 > threshold, hue differences taken on the circle.
    Where a pixel has only become darker (by shadow_min at most), value does not count, and the
    noise of hue and saturation, which goes with 1 / value, is taken at the darker value.
    """
    pixels, mean, precision = hsv.reshape(-1, 3), test.mean, test.precision
    if at is not None:
        pixels, mean = pixels.take(at, axis=0), mean.take(at, axis=1)
        precision = precision.take(at, axis=1)
    delta = pixels.T.astype(np.float32, order="C")
    delta -= mean
    hue = np.abs(delta[0])
    delta[0] = np.minimum(hue, 256.0 - hue)
    loss = delta[2].copy()
    delta *= delta
    delta *= precision
    colour = delta[0] + delta[1]
    far: np.ndarray = (colour + delta[2]) > test.threshold
    if test.shadow_min < 1.0:
        value = mean[2]
        shade = far & (loss < 0) & (loss >= (test.shadow_min - 1.0) * value)
        kept = 1.0 + loss / np.maximum(value, 1.0)
        far &= ~shade | (colour * kept * kept > test.threshold)
    return far
