"""The face as painted on the head: brows, eyes, lips, beard, and a few expressions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.person.hair import hairline
from sim.person.head import EYE_Y, EYE_Z, angles, face_points
from sim.person.skin import FLUSH, mottled
from sim.specs import Appearance
from sim.surfaces.textures import Texture, soft, to_bytes, value_noise

LIP_TINT = np.array([0.90, 0.755, 0.755])  # times the skin: keeps hue and saturation inside skin's
_MOUTH_Z = -0.0525
_SPOT_ENDS = 7.0  # of its height: beyond, a soft spot is below the last bit of the colours


@dataclass(frozen=True)
class Expression:
    """How a face departs from rest, on the average head [m].

    brows_m: how far they are raised; corners_m: of the mouth, likewise; wide: the mouth's width
    over that at rest; open_m: between the lips; lids: the eyes' opening over that at rest.
    """

    brows_m: float = 0.0
    corners_m: float = 0.0
    wide: float = 1.0
    open_m: float = 0.0
    lids: float = 1.0


EXPRESSIONS: Mapping[str, Expression] = {
    "neutral": Expression(),
    "smile": Expression(0.001, 0.0060, 1.16, 0.0042, 0.88),
    "open_mouth": Expression(0.002, -0.0005, 0.92, 0.0150, 1.05),
    "brows_up": Expression(0.0065, 0.0, 0.97, 0.0, 1.20),
}


def face_texture(rng: np.random.Generator, appearance: Appearance, size: int = 320) -> Texture:
    """Skin with brows, eyes, lips and a soft blush, for `head_surface`."""
    points = _texels(size)
    rgb = mottled(rng, points.shape[1:], appearance.skin_rgb)
    # The picture spans the whole head; features are painted on its front alone.
    front = np.s_[size // 16 : -size // 20, size * 15 // 32 : -size * 15 // 32]
    canvas = _Canvas(points[:, *front], rgb[front], appearance)
    expression = EXPRESSIONS[appearance.expression]
    _shade(canvas, expression)
    if appearance.beard:
        _beard(canvas, rng)
    _mouth(canvas, expression)
    _brows(canvas, expression, rng)
    _eyes(canvas, expression)
    if appearance.hair != "bald":
        # The skin shows between the first hairs.
        x, y, z = points
        ragged = 0.0016 * value_noise(rng, x.shape, (12, size))
        roots = soft(z - hairline(x, y, appearance.hair) + 0.0005 + ragged, 0.0028)
        rgb = rgb + (canvas.hair - rgb) * 0.92 * roots[..., None]
    return to_bytes(rgb)


@lru_cache(maxsize=1)
def _texels(size: int) -> Floats:
    """Where the texels lie on the average head [m]: x, y, z (3, size, 2 * size)."""
    points = face_points(*angles(size, 2 * size), features=False)
    return readonly(np.moveaxis(points, -1, 0), (3, size, 2 * size), "texels")


class _Canvas:
    """The skin (h, w, 3) being painted, in place, and where its texels lie on the average head [m].

    points: x ahead, y left, z up (3, h, w), z the same along a row; side (h, w): from the middle.
    Only the front is painted.
    """

    def __init__(self, points: Floats, rgb: Floats, appearance: Appearance) -> None:
        self.x, self.y, self.z = self._points = points
        self.side = np.abs(self.y)
        self.front = soft(self.x - 0.045, 0.02)
        self.rgb, self._appearance = rgb, appearance
        self.skin, self.hair = np.array(appearance.skin_rgb), np.array(appearance.hair_rgb)

    def rows(self, low_m: float, high_m: float) -> slice:
        """The rows between two heights."""
        inside = np.flatnonzero((self.z[:, 0] >= low_m) & (self.z[:, 0] <= high_m))
        return slice(inside[0], inside[-1] + 1) if len(inside) else slice(0, 0)

    def part(self, rows: slice) -> _Canvas:
        """A piece of this canvas, for what changes nothing outside."""
        return _Canvas(self._points[:, rows], self.rgb[rows], self._appearance)

    def paint(self, mask: Floats, colour: Floats, strength: float = 1.0) -> None:
        """Mix a colour in where mask (h, w) is."""
        self.rgb += (colour - self.rgb) * (mask * self.front * strength)[..., None]

    def tint(self, mask: Floats, gain: Floats) -> None:
        """Multiply by a gain (3,) where mask (h, w) is."""
        self.rgb *= 1.0 + (mask * self.front)[..., None] * (gain - 1.0)

    def spot(self, side: float, z: float, wide: float, high: float) -> Floats:
        """A soft spot on both sides of the face."""
        return np.asarray(np.exp(-(((self.side - side) / wide) ** 2) - ((self.z - z) / high) ** 2))

    def tint_spot(
        self, place: tuple[float, float, float, float], gain: Floats, strength: float = 1.0
    ) -> None:
        """Tint a `spot` of this place and size."""
        _, z, _, high = place
        part = self.part(self.rows(z - _SPOT_ENDS * high, z + _SPOT_ENDS * high))
        part.tint(strength * part.spot(*place), gain)


def _shade(c: _Canvas, expression: Expression) -> None:
    """Blush of cheeks, nose and chin; shade in the sockets and beside the mouth."""
    smile = expression.corners_m / 0.006
    c.tint_spot((0.042, -0.024 + 0.003 * smile, 0.016, 0.014), FLUSH)
    c.tint_spot((0.0, -0.024, 0.012, 0.012), FLUSH, 0.7)
    c.tint_spot((0.0, -0.086, 0.016, 0.010), FLUSH, 0.4)
    c.tint_spot((EYE_Y, EYE_Z + 0.004, 0.017, 0.011), np.full(3, 0.86))
    c.tint_spot((EYE_Y - 0.004, EYE_Z - 0.0115, 0.010, 0.0022), np.full(3, 0.91))
    c.tint_spot((0.0, -0.0645, 0.011, 0.0030), np.full(3, 0.90))
    c.tint_spot((0.0, -0.041, 0.0022, 0.0050), np.full(3, 0.93))
    # From the wings of the nose round the corners of the mouth.
    beside = c.part(c.rows(-0.065, -0.020))
    fold = 0.0165 + 0.0125 * np.clip((-0.030 - beside.z) / 0.022, 0.0, 1.0) * expression.wide
    there = soft(beside.z + 0.056, 0.006) * soft(-0.029 - beside.z, 0.004)
    depth = 0.07 + 0.14 * max(smile, 0.0)
    beside.tint(there * np.exp(-(((beside.side - fold) / 0.0022) ** 2)), np.full(3, 1.0 - depth))
    nostrils = c.part(c.rows(-0.055, -0.015))
    nostrils.paint(nostrils.spot(0.0075, -0.0345, 0.003, 0.0022), c.skin * 0.45)
    if expression.brows_m > 0.004:  # a brow that is raised far wrinkles the forehead
        for z in (0.046, 0.053, 0.060):
            c.tint_spot((0.012, z, 0.020, 0.0009), np.full(3, 0.88))


def _beard(c: _Canvas, rng: np.random.Generator) -> None:
    rows = c.rows(-1.0, 0.03)
    stubble = 1 + 0.25 * rng.standard_normal(c.z.shape)[rows, :, None]
    c = c.part(rows)
    jaw = soft(-(c.z + 0.036) - 0.25 * (0.05 - c.side), 0.012) + np.exp(
        -((c.side / 0.027) ** 4) - ((c.z + 0.041) / 0.006) ** 2
    )
    c.paint(np.clip(jaw, 0, 1), c.hair * stubble + 0.02, 0.9)


def _mouth(c: _Canvas, expression: Expression) -> None:
    """Lips about a dark line, or about teeth and the dark behind them."""
    c = c.part(c.rows(_MOUTH_Z - 0.04, _MOUTH_Z + 0.04))
    across = c.side / (0.0245 * expression.wide)
    inside = np.clip(1.0 - across**2, 0.0, 1.0)
    middle = c.z - _MOUTH_Z + 0.3 * expression.open_m - expression.corners_m * across**2
    gap = expression.open_m * inside**0.7
    top, bottom = 0.35 * gap, -0.65 * gap
    bow = 1.0 - 0.28 * np.exp(-((c.side / 0.0035) ** 2))
    upper = soft(np.minimum(middle - top, top + 0.0066 * inside * bow - middle), 0.0008)
    lower = soft(np.minimum(bottom - middle, middle - bottom + 0.0084 * inside), 0.0010)
    within = soft(1.0 - across, 0.04)
    c.paint(upper * within, c.skin * LIP_TINT * 0.95)
    c.paint(lower * within, c.skin * LIP_TINT * 1.02)
    c.tint(0.6 * lower * c.spot(0.0, _MOUTH_Z - 0.006, 0.009, 0.0018), np.full(3, 1.10))
    if expression.open_m > 0.0:
        hole = soft(np.minimum(top - middle, middle - bottom), 0.0007) * within
        c.paint(hole, np.array([0.16, 0.055, 0.05]))
        teeth = soft(middle - top + min(0.0052, 0.75 * expression.open_m), 0.0006)
        c.paint(hole * teeth * (across < 0.80), np.array([0.80, 0.77, 0.71]))
    line = soft(0.0010 - np.abs(middle - top), 0.0007) * within
    c.paint(line, c.skin * 0.40, 0.9 if expression.open_m == 0.0 else 0.5)


def _brows(c: _Canvas, expression: Expression, rng: np.random.Generator) -> None:
    hairs = 0.0005 * value_noise(rng, c.z.shape, (30, c.z.shape[1] // 2))
    rows = c.rows(EYE_Z - 0.015, EYE_Z + 0.05)
    c, hairs = c.part(rows), hairs[rows]
    aside = c.side - EYE_Y
    raised = expression.brows_m * (1.0 + 0.15 * np.cos(aside / 0.012))
    arch = EYE_Z + 0.0185 + 0.005 * np.cos(aside / 0.011) + raised
    thick = 0.0036 * soft(0.0185 - np.abs(aside - 0.001), 0.005)
    mask = soft(thick - np.abs(c.z - arch) + hairs, 0.0013) * (thick > 0.0004)
    c.paint(mask, c.hair * 1.05, 0.88)


def _eyes(c: _Canvas, expression: Expression) -> None:
    """Almond of sclera with the lid's shade, iris, pupil, a glint; lashes, a crease above."""
    c = c.part(c.rows(EYE_Z - 0.03, EYE_Z + 0.03))
    across = (c.side - EYE_Y) / 0.0155
    half = 0.0062 * expression.lids * (1 - across**2)
    up = c.z - EYE_Z
    almond = soft(half - np.abs(up), 0.0010)
    c.paint(almond, np.array([0.84, 0.82, 0.79]))
    c.tint(almond * soft(up - 0.35 * half, 0.0025), np.full(3, 0.80))
    r = np.hypot(c.side - EYE_Y + 0.0003, up - 0.0004)
    c.paint(almond * soft(0.0062 - r, 0.0008), np.array([0.20, 0.14, 0.10]))
    c.paint(almond * soft(0.0029 - r, 0.0006), np.array([0.03, 0.03, 0.03]))
    glint = np.hypot(c.y - np.sign(c.y) * EYE_Y - 0.002, up - 0.0025)
    c.paint(soft(0.0013 - glint, 0.0005), np.array([1.0, 1.0, 1.0]), 0.8)
    rim = np.maximum(half, 0)
    lashes = soft(0.0013 - np.abs(up - rim), 0.0008) * (np.abs(across) < 1.08)
    c.paint(lashes, np.array([0.10, 0.07, 0.05]), 0.9)
    lower = soft(0.0007 - np.abs(up + rim), 0.0008) * (np.abs(across) < 1.0)
    c.paint(lower, c.skin * 0.60, 0.6)
    crease = soft(0.0008 - np.abs(up - rim - 0.0040 * np.clip(1.1 - across**2, 0, 1)), 0.0009)
    c.paint(crease * (np.abs(across) < 1.0), c.skin * 0.66, 0.6)
