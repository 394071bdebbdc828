"""The head: skin, painted features and hair as surfaces in the head frame (numpy only)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.anatomy import Anatomy
from sim.specs import Appearance
from sim.surfaces.shapes import Surface, capped, closed_grid, extremes, interpolate
from sim.surfaces.textures import Texture, soft, to_bytes, value_noise

RINGS, SIDES = 44, 52
HAIR = ("short", "long", "bald")
EYE_Y, EYE_Z = 0.0325, 0.006  # of an average head; all features scale with the head's size
LIP_TINT = np.array([0.88, 0.79, 0.79])  # times the skin: keeps hue and saturation inside skin's
_AVERAGE = (0.099, 0.0761, 0.1127)  # half depth, breadth, height [m] the features are drawn for


def head_surface(anatomy: Anatomy) -> Surface:
    """Skull and face, origin at the head's centre, x out of the face, y left, z to the crown."""
    theta, phi = _angles(RINGS, SIDES + 1)
    return closed_grid(_scaled(_face(theta, phi), anatomy))


def hair_surface(anatomy: Anatomy) -> Surface:
    """A cap of hair: the head's surface pushed out where hair grows and in where it does not."""
    theta, phi = _angles(RINGS - 8, SIDES - 7)
    points = _face(theta, phi, features=False)
    x, y, z = np.moveaxis(points, -1, 0)
    grows = soft(z - _hairline(x, y), 0.009)
    out = points / np.linalg.norm(points, axis=-1, keepdims=True)
    lift = 0.012 + 0.004 * np.clip(z / 0.1, 0, 1)
    return closed_grid(
        _scaled(points + out * (-0.012 + (lift + 0.012) * grows)[..., None], anatomy)
    )


def _hairline(x: Floats, y: Floats) -> Floats:
    """Height above which hair grows on the average head [m]."""
    knots = np.array([-0.105, -0.05, -0.015, 0.02, 0.055, 0.085, 0.105])
    line = np.interp(x, knots, [-0.075, -0.06, -0.012, 0.022, 0.058, 0.075, 0.08])
    return np.asarray(line + 0.0025 * np.sin(230 * y) + 0.004 * np.cos(90 * (y - 0.02)))


# Long hair: height, half depth and half breadth outside, thickness, azimuth at which it begins.
_CURTAIN = np.array(
    [
        [-0.135, 0.098, 0.091, 0.010, 0.92],
        [-0.110, 0.108, 0.097, 0.020, 0.98],
        [-0.060, 0.114, 0.095, 0.023, 1.10],
        [0.000, 0.114, 0.090, 0.022, 1.25],
        [0.040, 0.104, 0.084, 0.018, 1.32],
        [0.080, 0.080, 0.062, 0.012, 1.50],
    ]
)


@lru_cache(maxsize=8)
def _average_outline(hair: str) -> tuple[Floats, Floats]:
    theta, phi = _angles(60, 73)
    points = _face(theta, phi).reshape(-1, 3)
    x, y, z = points.T
    plain = _face(theta, phi, features=False).reshape(-1, 3)
    bare = np.ones(len(points), dtype=bool)
    if hair != "bald":
        bare = plain[:, 2] < _hairline(plain[:, 0], plain[:, 1])
        # The nape is behind jaw and collar.
        bare &= x > -0.03
    if hair == "long":
        bare &= np.abs(np.arctan2(y, x)) < np.interp(z, _CURTAIN[:, 0], _CURTAIN[:, 4])
    covered = points[~bare] + 0.013 * points[~bare] / np.linalg.norm(
        points[~bare], axis=1, keepdims=True
    )
    if hair == "long":
        falls = _CURTAIN[:, :3]
        turn = np.linspace(1.2, 2 * np.pi - 1.2, 12)
        ring = np.stack(
            [
                falls[:, 1:2] * np.cos(turn),
                falls[:, 2:3] * np.sin(turn),
                np.broadcast_to(falls[:, :1], (len(falls), len(turn))),
            ],
            axis=-1,
        )
        covered = np.concatenate([covered, ring.reshape(-1, 3)])
    return (
        readonly(extremes(points[bare]), (None, 3), "bare"),
        readonly(extremes(covered), (None, 3), "hair"),
    )


@lru_cache(maxsize=1)
def _average_beard() -> Floats:
    """Points about the jaw where a beard is dense; the moustache is too thin to part the face."""
    points = _face(*_angles(60, 73)).reshape(-1, 3)
    x, y, z = points.T
    dense = (z < -0.042 - 0.25 * (0.05 - np.abs(y))) & (x > 0.04)
    return readonly(extremes(points[dense]), (None, 3), "beard")


def beard_points(anatomy: Anatomy) -> Floats:
    """Points (n, 3) about the bearded part of the face, head frame."""
    return _scaled(_average_beard(), anatomy)


def outline_points(anatomy: Anatomy, hair: str) -> tuple[Floats, Floats]:
    """Points (n, 3) on the bare face, and (m, 3) on the hair, head frame; none of a bald head."""
    bare, covered = _average_outline(hair)
    return _scaled(bare, anatomy), _scaled(covered, anatomy)


def curtain_surface(anatomy: Anatomy) -> Surface:
    """Long hair: it falls from the temples and the back of the head to the collar."""
    z = np.linspace(0.075, -0.132, 16)
    depth, breadth, thickness, begin = interpolate(_CURTAIN, z).T[..., None]
    there = np.linspace(0, 1, 34)
    turn = begin + (2 * np.pi - 2 * begin) * there
    # Strands, fuller towards the ends; the rims are drawn in, so that they are round.
    strands = 1 + 0.012 * np.sin(31 * turn) * np.clip((0.06 - z) / 0.15, 0, 1)[:, None]
    rim = 1 - 0.10 * np.exp(-there / 0.02) - 0.10 * np.exp(-(1 - there) / 0.02)
    outside = np.stack([depth * np.cos(turn), breadth * np.sin(turn)], axis=-1)
    outside = outside * (strands * rim)[..., None]
    inside = outside * (1 - thickness / np.hypot(depth, breadth) * 1.35)[..., None]
    outline = np.concatenate([outside, inside[:, ::-1], outside[:, :1]], axis=1)
    ends = z[:, None] + 0.0
    lowest = np.clip((-0.06 - z) / 0.07, 0, 1)[:, None]
    around = np.concatenate([turn, turn[:, ::-1], turn[:, :1]], axis=1)
    grid = np.dstack([outline, ends + 0.005 * lowest * np.sin(13 * around)])
    return closed_grid(_scaled(capped(grid), anatomy))


def face_texture(rng: np.random.Generator, appearance: Appearance, size: int = 320) -> Texture:
    """Skin with brows, eyes, lips and a soft blush, for `head_surface`."""
    theta, phi = _angles(size, 2 * size)
    points = _face(theta, phi, features=False)
    x, y, z = np.moveaxis(points, -1, 0)
    front = soft(x - 0.045, 0.02)
    skin = np.array(appearance.skin_rgb)
    hair = np.array(appearance.hair_rgb)
    shape = y.shape
    tone = 1 + 0.012 * value_noise(rng, shape, (60, 120)) + 0.008 * rng.standard_normal(shape)
    rgb = skin * tone[..., None]
    side = np.abs(y)

    def paint(mask: Floats, colour: Floats, strength: float = 1.0) -> None:
        nonlocal rgb
        rgb = rgb + (colour - rgb) * (mask * front * strength)[..., None]

    cheek = np.exp(-(((side - 0.042) / 0.016) ** 2) - ((z + 0.026) / 0.014) ** 2)
    paint(cheek, skin * np.array([1.0, 0.95, 0.95]), 0.8)
    socket = np.exp(-(((side - EYE_Y) / 0.017) ** 2) - ((z - EYE_Z - 0.004) / 0.011) ** 2)
    paint(socket, skin * 0.80, 0.7)
    if appearance.beard:
        jaw = soft(-(z + 0.036) - 0.25 * (0.05 - side), 0.012) + np.exp(
            -((side / 0.027) ** 4) - ((z + 0.041) / 0.006) ** 2
        )
        stubble = 1 + 0.25 * rng.standard_normal(shape)[..., None]
        paint(np.clip(jaw, 0, 1), hair * stubble + 0.02, 0.9)
    # Lips: the upper with a bow, the lower fuller, a dark line between.
    mouth_z = z + 0.0525
    upper = soft(0.0055 * (1 - (side / 0.025) ** 2) - np.abs(mouth_z - 0.0025), 0.0012)
    lower = soft(0.0065 * (1 - (side / 0.022) ** 2) - np.abs(mouth_z + 0.004), 0.0014)
    paint(np.maximum(upper, lower), skin * LIP_TINT)
    paint(soft(0.0011 - np.abs(mouth_z + 8 * side**2 * 0.3), 0.0008) * (side < 0.023), skin * 0.42)
    paint(np.exp(-(((side - 0.0075) / 0.003) ** 2) - ((z + 0.0345) / 0.0022) ** 2), skin * 0.45)
    arch = EYE_Z + 0.0205 + 0.005 * np.cos((side - EYE_Y) / 0.011) - 0.002
    thick = 0.0034 * soft(0.0185 - np.abs(side - EYE_Y - 0.001), 0.005)
    paint(soft(thick - np.abs(z - arch), 0.0012) * (thick > 0.0004), hair * 1.05, 0.92)
    # Eyes: almond of sclera, iris, pupil, a glint, the upper lid's line.
    across = (side - EYE_Y) / 0.0155
    half = 0.0062 * (1 - across**2)
    almond = soft(half - np.abs(z - EYE_Z), 0.0010)
    paint(almond, np.array([0.86, 0.85, 0.83]))
    r = np.hypot(side - EYE_Y + 0.0003, z - EYE_Z - 0.0004)
    paint(almond * soft(0.0062 - r, 0.0008), np.array([0.20, 0.15, 0.12]))
    paint(almond * soft(0.0029 - r, 0.0006), np.array([0.03, 0.03, 0.03]))
    glint = np.hypot(y - np.sign(y) * EYE_Y - 0.002, z - EYE_Z - 0.0025)
    paint(soft(0.0013 - glint, 0.0005), np.array([1.0, 1.0, 1.0]), 0.8)
    lid = soft(0.0014 - np.abs(z - EYE_Z - np.maximum(half, 0)), 0.0008) * (np.abs(across) < 1.05)
    paint(lid, np.array([0.12, 0.08, 0.06]), 0.9)
    return to_bytes(rgb)


def hair_texture(rng: np.random.Generator, appearance: Appearance, size: int = 256) -> Texture:
    """Strands from the crown down."""
    strands = value_noise(rng, (size, size), (4, size // 2))
    waves = value_noise(rng, (size, size), (6, 24))
    luminance = 1 + 0.22 * strands + 0.15 * waves
    return to_bytes(np.array(appearance.hair_rgb) * luminance[..., None])


def _angles(rings: int, columns: int) -> tuple[Floats, Floats]:
    """Polar angle from the crown, azimuth from the face; denser in front, the seam at the back."""
    s = np.linspace(-1, 1, columns)
    theta, warped = np.meshgrid(
        np.linspace(0, np.pi, rings), np.pi * np.sign(s) * np.abs(s) ** 1.3, indexing="ij"
    )
    return theta, warped


def _face(theta: Floats, phi: Floats, features: bool = True) -> Floats:
    """Points (..., 3) of the average head [m]."""
    a, b, c = _AVERAGE
    up = np.cos(theta)
    below = np.clip(-up, 0, 1)
    # Under the cheekbones the cross-sections shrink slower than an ellipsoid's: a jaw, not an egg.
    # Above the temples as well: a skull, not a cone.
    ring = np.sin(theta) ** (1 - 0.38 * below - 0.20 * np.clip(up, 0, 1))
    front = np.clip(np.cos(phi), 0, 1) ** 1.5
    back = np.clip(-np.cos(phi), 0, 1)
    width = 1 - 0.24 * below**1.6
    depth = 1 - 0.09 * front - 0.10 * front * below - 0.42 * back * below**0.8
    square = 1 + 0.05 * np.sin(2 * phi) ** 2
    x = a * np.cos(phi) * ring * depth * square
    y = b * np.sin(phi) * ring * width * square
    z = c * up
    if features:
        side = np.abs(y)

        def bump(dy: float, dz: float, wy: float, wz: float) -> Floats:
            return np.asarray(np.exp(-(((side - dy) / wy) ** 2) - ((z - dz) / wz) ** 2))

        tip = np.clip((0.016 - z) / 0.045, 0, 1)
        nose = 0.025 * tip * soft(z + 0.034, 0.004)
        nose = nose * np.exp(-((side / (0.0065 + 0.0055 * tip)) ** 2))
        nose = nose + 0.004 * bump(0.0115, -0.029, 0.005, 0.006)
        x = x + front * (
            nose
            - 0.008 * bump(EYE_Y, EYE_Z + 0.003, 0.015, 0.010)
            + 0.0035 * bump(EYE_Y, EYE_Z, 0.010, 0.0065)
            + 0.0040 * bump(0.022, 0.027, 0.026, 0.008)
            + 0.0045 * bump(0.046, -0.014, 0.015, 0.013)
            + 0.0050 * bump(0.0, -0.053, 0.019, 0.011)
            - 0.0035 * bump(0.0, -0.068, 0.020, 0.006)
            + 0.0085 * bump(0.0, -0.090, 0.018, 0.015)
        )
    return np.stack([x, y, z], axis=-1)


def _scaled(points: Floats, anatomy: Anatomy) -> Floats:
    half = np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m]) / 2
    return np.asarray(points * half / np.array(_AVERAGE))
