"""Procedural pictures: the view from a window, portraits, prints, screens. uint8 RGB (h, w, 3)."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RGB
from sim.surfaces.textures import Texture, painting, soft, to_bytes, value_noise


def _grid(shape: tuple[int, int]) -> tuple[Floats, Floats]:
    """Height 0-1 from the top and place 0-1 from the left of each pixel."""
    v, u = np.mgrid[0 : 1 : shape[0] * 1j, 0 : 1 : shape[1] * 1j]
    return v, u


def outdoors(rng: np.random.Generator, shape: tuple[int, int] = (256, 256)) -> Texture:
    """Sky over trees or houses, out of focus, as a camera sees it from inside."""
    v, u = _grid(shape)
    skies = np.array(
        [
            [[0.60, 0.74, 0.92], [0.86, 0.91, 0.96]],
            [[0.76, 0.80, 0.85], [0.90, 0.92, 0.93]],
            [[0.66, 0.70, 0.86], [0.97, 0.86, 0.74]],
        ]
    )
    top, low = skies[rng.integers(len(skies))]
    picture = top + (low - top) * np.clip(1.5 * v, 0, 1)[..., None]
    clouds = np.clip(value_noise(rng, shape, (7, 4)), 0, 2)
    picture = picture + 0.07 * (clouds * (v < 0.6))[..., None]
    horizon = float(rng.uniform(0.50, 0.72))
    if rng.random() < 0.5:  # houses
        edge = 0.0
        while edge < 1.0:
            wide, roof = rng.uniform(0.10, 0.28), horizon - rng.uniform(0.05, 0.35)
            front = (u >= edge) & (u < edge + wide) & (v > roof)
            colour = rng.uniform(0.35, 0.7) * np.array([1.0, 0.97, 0.94])
            picture = np.where(front[..., None], colour, picture)
            panes = (np.mod((u - edge) * 22, 1) < 0.45) & (np.mod((v - roof) * 16, 1) < 0.5)
            picture = np.where((front & panes)[..., None], colour * 0.55, picture)
            edge += wide
    else:
        for layer in range(3):
            bumps = value_noise(rng, (1, shape[1]), (1, 6 + 5 * layer))[0]
            line = horizon + 0.09 * layer + 0.05 * bumps
            green = np.array([0.30, 0.43, 0.26]) * (1.15 - 0.22 * layer)
            leaves = 1 + 0.16 * value_noise(rng, shape, (30, 40))[..., None]
            picture = np.where((v > line)[..., None], green * leaves, picture)
    return np.asarray(cv2.GaussianBlur(to_bytes(picture), (9, 9), 0))


def portrait(rng: np.random.Generator, skin: RGB, shape: tuple[int, int] = (384, 272)) -> Texture:
    """A poster of a person from the chest up, of natural size and colours, one hand raised."""
    v, u = _grid(shape)
    aspect = shape[0] / shape[1]
    x, y = u - 0.5, (v - 0.42) * aspect
    ground = rng.uniform(0.25, 0.75, 3)
    picture = ground * (1.12 - 0.3 * v[..., None])
    hair, shirt = rng.uniform(0.04, 0.30, 3), rng.uniform(0.1, 0.7, 3)
    flesh = np.array(skin)

    def put(mask: Floats, colour: Floats) -> None:
        nonlocal picture
        picture = picture + (colour - picture) * mask[..., None]

    def oval(cx: float, cy: float, a: float, b: float, edge: float = 0.05) -> Floats:
        return soft(1 - np.hypot((x - cx) / a, (y - cy) / b), edge)

    shade = flesh * (1.04 - 0.5 * np.clip(x + 0.1, 0, 0.3))[..., None]
    put(oval(0, -0.03, 0.22, 0.285), hair)
    shoulders = soft(y - 0.36 - 1.1 * np.abs(x) ** 2.2, 0.02)
    put(soft(0.085 - np.abs(x), 0.01) * soft(y - 0.1, 0.02), 0.88 * shade)
    put(shoulders, shirt * (1 - 0.35 * np.abs(x))[..., None])
    put(oval(0, 0.02, 0.165, 0.235), shade)
    put(oval(0, -0.20, 0.19, 0.10), hair)
    for side in (-1, 1):
        put(oval(0.068 * side, -0.005, 0.034, 0.015), np.array([0.9, 0.9, 0.88]))
        put(oval(0.068 * side, -0.005, 0.014, 0.014), np.array([0.10, 0.08, 0.07]))
        put(oval(0.068 * side, -0.048, 0.045, 0.010), hair)
    put(oval(0.0, 0.060, 0.024, 0.018), 0.86 * flesh)
    put(oval(0.0, 0.125, 0.058, 0.017), flesh * np.array([0.86, 0.62, 0.60]))
    hand_x = 0.33 * (1 if rng.random() < 0.5 else -1)
    put(oval(hand_x, 0.22, 0.075, 0.085), shade)
    for finger in range(4):
        lean = (finger - 1.5) * 0.036
        put(oval(hand_x + lean, 0.105 + 0.02 * abs(finger - 1.5), 0.017, 0.085, 0.12), shade)
    put(oval(hand_x - 0.075 * np.sign(hand_x), 0.17, 0.022, 0.07, 0.12), shade)
    put(soft(0.055 - np.abs(x - hand_x), 0.01) * soft(y - 0.28, 0.02), shirt * 0.9)
    return to_bytes(picture * (1 + 0.012 * rng.standard_normal(shape))[..., None])


def print_(rng: np.random.Generator, shape: tuple[int, int] = (192, 192)) -> Texture:
    """A picture for a wall: a landscape, colour fields, circles, or a photograph's blur."""
    kind = int(rng.integers(4))
    if kind == 0:
        return np.asarray(cv2.resize(painting(rng, warm=bool(rng.random() < 0.25)), shape[::-1]))
    v, u = _grid(shape)
    picture = np.broadcast_to(rng.uniform(0.6, 0.95, 3), (*shape, 3))
    if kind == 1:
        edges = np.sort(rng.uniform(0.1, 0.9, 3))
        for edge in edges:
            picture = np.where((v > edge)[..., None], rng.uniform(0.1, 0.9, 3), picture)
        upright = soft(u - rng.uniform(0.2, 0.8), 0.003)[..., None]
        picture = picture * (1 - 0.25 * upright)
    elif kind == 2:
        for _ in range(int(rng.integers(3, 8))):
            cx, cy, r = rng.uniform(0.1, 0.9), rng.uniform(0.1, 0.9), rng.uniform(0.06, 0.3)
            mask = soft(r - np.hypot(u - cx, v - cy), 0.004)
            picture = picture + (rng.uniform(0.05, 0.9, 3) - picture) * 0.9 * mask[..., None]
    else:
        for _ in range(3):
            mask = soft(value_noise(rng, shape, (4, 4)), 0.5)[..., None]
            picture = picture + (rng.uniform(0.05, 0.85, 3) - picture) * mask
    return to_bytes(picture)


def screen(rng: np.random.Generator, shape: tuple[int, int] = (160, 256)) -> Texture:
    """A computer's screen that is on: windows with lines of text, or a picture."""
    v, u = _grid(shape)
    if rng.random() < 0.3:
        return outdoors(rng, shape)
    picture = rng.uniform(0.08, 0.45, 3) * (1.2 - 0.4 * v[..., None])
    for _ in range(int(rng.integers(1, 4))):
        x0, y0 = rng.uniform(0.02, 0.5), rng.uniform(0.05, 0.45)
        x1, y1 = x0 + rng.uniform(0.3, 0.48), y0 + rng.uniform(0.3, 0.5)
        inside = (u > x0) & (u < x1) & (v > y0) & (v < y1)
        dark = rng.random() < 0.4
        sheet = np.array([0.13, 0.14, 0.17]) if dark else np.array([0.93, 0.94, 0.95])
        picture = np.where(inside[..., None], sheet, picture)
        bar = inside & (v < y0 + 0.045)
        picture = np.where(bar[..., None], rng.uniform(0.2, 0.6, 3), picture)
        line = np.floor((v - y0) / 0.04).astype(int)
        ends = x0 + 0.03 + rng.uniform(0.2, 0.95, line.max() + 2) * (x1 - x0 - 0.06)
        text = inside & (v > y0 + 0.07) & (u > x0 + 0.03) & (u < ends[np.clip(line, 0, None)])
        text &= np.mod((v - y0) / 0.04, 1) < 0.45
        ink = np.array([0.75, 0.78, 0.72]) if dark else np.array([0.35, 0.37, 0.42])
        picture = np.where(text[..., None], ink, picture)
    return to_bytes(picture)
