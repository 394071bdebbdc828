"""Colours of light, and the light of a picture's values."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RGB

# A pure power, unlike sRGB's curve: there, a factor of the light is a factor of the picture's
# values, and the renderer's lights are factors of the picture's values.
GAMMA = 2.2
NEUTRAL_K = 6500.0  # the light that pictures are made for: its white is white
SECOND_RADIATION_M_K = 1.438777e-2  # h c / k
XYZ_TO_RGB = np.array(  # to linear sRGB, IEC 61966-2-1
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


def light_rgb(temperature_K: float) -> RGB:
    """Factors of a picture's red, green and blue values under a black body's light.

    Relative to 6500 K at equal luminance: for the colour of the renderer's lights.
    Raises ValueError outside 2000 to 25000 K: redder light has no blue that a picture can show.
    """
    red, green, blue = (float(c) for c in linear_light(temperature_K) ** (1 / GAMMA))
    return red, green, blue


def balance_rgb(temperature_K: float) -> RGB:
    """Gains of the light's red, green and blue in a camera balanced for this temperature.

    Under light of that temperature white is white again. Raises as `light_rgb`.
    """
    red, green, blue = (float(c) for c in 1 / linear_light(temperature_K))
    return red, green, blue


def linear_light(temperature_K: float) -> Floats:
    """Linear red, green, blue (3,) of a black body relative to 6500 K, equally bright."""
    if not 2000 <= temperature_K <= 25_000:  # NaN fails as well
        raise ValueError(f"temperature_K must be from 2000 to 25000, got {temperature_K:g}")
    ours, neutral = (XYZ_TO_RGB @ black_body_xyz(T) for T in (temperature_K, NEUTRAL_K))
    return np.asarray(ours / neutral)


def black_body_xyz(temperature_K: float) -> Floats:
    """CIE 1931 X, Y, Z (3,) of a black body, Y = 1: Planck's law under the observer's curves."""
    nm = np.arange(360.0, 831.0, 5.0)
    power = nm**-5.0 / np.expm1(SECOND_RADIATION_M_K / (nm * 1e-9 * temperature_K))
    xyz = observer(nm) @ power
    return np.asarray(xyz / xyz[1])


def observer(nm: Floats) -> Floats:
    """The CIE 1931 colour matching functions (3, n), as sums of Gaussians (Wyman et al. 2013)."""

    def lobe(height: float, peak: float, below: float, above: float) -> Floats:
        width = np.where(nm < peak, below, above)
        return np.asarray(height * np.exp(-0.5 * ((nm - peak) / width) ** 2))

    x = lobe(0.362, 442.0, 16.0, 26.7) + lobe(1.056, 599.8, 37.9, 31.0)
    x = x - lobe(0.065, 501.1, 20.4, 26.2)
    y = lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1)
    z = lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8)
    return np.array([x, y, z])
