"""The sensor of a real camera, applied to a rendered picture.

In a camera's order: the mean light of the exposure; gains of the light (exposure, white balance,
flicker); noise of the light and of reading out; 8 bits; JPEG. A picture's values v are light
(v / 255) ** GAMMA. Values that the renderer has clipped to white stay white at any exposure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from pjpdaf.arrays import Floats, Image
from sim.camera.colour import GAMMA
from sim.randomness import generator
from sim.specs import RGB, SensorSpec

RANKS = 2**16
NO_JPEG = 100
MIDDLE_GREY = 128.0  # the value at which shot noise has its nominal spread
LIGHT_UNITS = 2**20 - 1  # white, in the whole numbers in which light is added up


def expose(
    picture: Image, spec: SensorSpec, seed: int, stream: str, frame: int, time_s: float = 0.0
) -> Image:
    """A rendered picture (h, w, 3) uint8 BGR as a camera outputs it.

    time_s: the middle of its exposure, for the flicker. The noise is addressed by (seed, stream,
    frame): it does not depend on any other picture.
    """
    gains = light_gains(spec, time_s)
    if gains != (1.0, 1.0, 1.0):
        picture = cv2.LUT(picture, gain_table(gains[::-1]))
    rng = generator(seed, f"noise/{stream}", frame)
    if spec.shot_noise_sd > 0:
        picture = shot_noise(picture, spec.noise_sd, spec.shot_noise_sd, rng)
    elif spec.noise_sd > 0:
        picture = read_noise(picture, spec.noise_sd, rng)
    else:
        picture = picture.copy()
    return picture if spec.jpeg_quality == NO_JPEG else compressed(picture, spec.jpeg_quality)


def mean_light(pictures: Sequence[Image]) -> Image:
    """Motion blur: the picture of the mean light of pictures of the same size."""
    if len(pictures) == 1:
        return pictures[0]
    light_of_grey, grey_of_light = light_tables()
    total = np.zeros(pictures[0].shape, np.int32)
    for picture in pictures:
        total += cv2.LUT(picture, light_of_grey)
    mean = (total + len(pictures) // 2) // len(pictures)
    return np.asarray(np.take(grey_of_light, mean))


def light_gains(spec: SensorSpec, time_s: float) -> RGB:
    """Gains of the light's red, green and blue in a picture whose exposure is centred on time_s.

    Exposure 2^EV, white balance, and the mean over the exposure of the flicker
    1 + a sin(2 pi f t + phase), which an exposure of whole periods does not see.
    """
    swing = spec.flicker * float(np.sinc(spec.flicker_hz * spec.exposure_time_s))
    phase = 2 * math.pi * spec.flicker_hz * time_s + spec.flicker_rad
    common = 2.0**spec.exposure_ev * (1.0 + swing * math.sin(phase))
    red, green, blue = (common * gain for gain in spec.white_balance_rgb)
    return red, green, blue


def gain_table(gains: tuple[float, float, float]) -> Image:
    """The value after these gains of the light of each value before, (1, 256, 3) uint8.

    In the order of the picture's channels; light above white is white.
    """
    values = np.arange(256.0)[:, None] * np.asarray(gains) ** (1 / GAMMA)
    return np.rint(np.minimum(values, 255.0)).astype(np.uint8)[None]


def read_noise(picture: Image, sd: float, rng: np.random.Generator) -> Image:
    """The picture with Gaussian noise of `sd` grey levels on every value."""
    # The picture is whole numbers, so rounding the sum is rounding the noise: a table will do.
    noise = cv2.LUT(_ranks(picture.shape, rng), rounded_gaussian(sd))
    return np.asarray(cv2.add(noise, picture, dtype=cv2.CV_8U), dtype=np.uint8)  # clips


def shot_noise(picture: Image, read_sd: float, shot_sd: float, rng: np.random.Generator) -> Image:
    """The picture with Gaussian noise of variance read_sd^2 + shot_sd^2 v / 128 at value v."""
    values = np.arange(256.0)
    sd = np.sqrt(read_sd**2 + shot_sd**2 * values / MIDDLE_GREY).astype(np.float32)
    noise = cv2.LUT(_ranks(picture.shape, rng), gaussian())
    noise *= cv2.LUT(picture, sd)
    noise += picture
    np.rint(noise, out=noise)
    np.clip(noise, 0, 255, out=noise)
    return np.asarray(noise, dtype=np.uint8)


def _ranks(shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.uint16]:
    """Uniform numbers below RANKS: those of `rng.integers`, at half its cost."""
    size = math.prod(shape)
    words = rng.bit_generator.random_raw(-(-size // 4)).astype("<u8", copy=False)
    return np.asarray(words.view("<u2")[:size].reshape(shape))


def compressed(picture: Image, quality: int) -> Image:
    """The picture after JPEG, as most cameras do it: half the resolution for the colours."""
    done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), dtype=np.uint8)


@lru_cache(maxsize=1)
def quantiles() -> Floats:
    """Quantiles (RANKS,) of the standard normal distribution, out to 4.3."""
    return np.asarray(ndtri((np.arange(RANKS) + 0.5) / RANKS))


@lru_cache(maxsize=1)
def gaussian() -> NDArray[np.float32]:
    """`quantiles` in single precision."""
    return quantiles().astype(np.float32)


@lru_cache(maxsize=8)
def rounded_gaussian(sd: float) -> NDArray[np.int16]:
    """Quantiles (RANKS,) of a Gaussian, rounded to whole grey levels; out to 4.3 sd."""
    return np.asarray(np.rint(sd * quantiles()), dtype=np.int16)


@lru_cache(maxsize=1)
def light_tables() -> tuple[NDArray[np.int32], Image]:
    """Light of each value (256,) in LIGHT_UNITS, and the value nearest to each light."""
    light = np.rint(LIGHT_UNITS * (np.arange(256) / 255.0) ** GAMMA)
    grey = np.rint(255.0 * (np.arange(LIGHT_UNITS + 1) / LIGHT_UNITS) ** (1 / GAMMA))
    return light.astype(np.int32), grey.astype(np.uint8)
