"""Shared by tests: a stereo rig, hypothesis strategies, a world of points instead of pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pjpdaf.camera import Camera, StereoRig, project
from pjpdaf.interfaces import Detections, Estimates

FOCAL_PX, BASE_M, DEPTH_M, DT_S = 540.0, 0.09, 1.3, 1.0 / 3.0
# World: x from the person to the cameras, y to the person's left, z up. Camera looks along -x:
# its x (right in the picture) is the person's left, world +y; its y (down) is world -z.
R_CW = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
HEAD_W, RIGHT_W, LEFT_W = (np.array(p) for p in ([0, 0, 1.2], [0.1, -0.2, 0.8], [0.1, 0.2, 0.8]))
START_W = np.array([HEAD_W, RIGHT_W, LEFT_W])


def camera_at(y_m: float, width_px: int = 640, height_px: int = 480) -> Camera:
    K = np.array(
        [
            [FOCAL_PX, 0, (width_px - 1) / 2],
            [0, FOCAL_PX, (height_px - 1) / 2],
            [0, 0, 1],
        ]
    )
    centre = np.array([DEPTH_M, y_m, 1.0])
    return Camera(K, R_CW, -R_CW @ centre, width_px, height_px)


def rig() -> StereoRig:
    return StereoRig(camera_at(-BASE_M / 2), camera_at(BASE_M / 2))


def detections(pixels: np.ndarray, areas: np.ndarray | None = None) -> Detections:
    pixels = np.asarray(pixels, dtype=float).reshape(-1, 2)
    n = len(pixels)
    ellipses = np.column_stack([pixels, np.full((n, 2), 20.0), np.zeros(n)])
    areas = np.full(n, 1500.0) if areas is None else areas
    return Detections(pixels, np.tile(np.eye(2) * 15.0, (n, 1, 1)), ellipses, areas)


@dataclass(frozen=True)
class PointWorld:
    """Detection noise [px], probability of a miss, mean clutter an image, merging distance [px]."""

    noise_px: float = 2.0
    miss: float = 0.05
    clutter: float = 0.2
    merge_px: float = 0.0

    def see(
        self, cameras: tuple[Camera, ...], points_w: np.ndarray, rng: np.random.Generator
    ) -> tuple[Detections, ...]:
        views = []
        for camera in cameras:
            pixels = project(camera, points_w) + rng.normal(0, self.noise_px, (len(points_w), 2))
            pixels = merged(pixels[rng.random(len(pixels)) >= self.miss], self.merge_px)
            n = rng.poisson(self.clutter)
            false = rng.random((n, 2)) * [camera.width_px, camera.height_px]
            views.append(detections(rng.permutation(np.concatenate([pixels, false]))))
        return tuple(views)


def merged(pixels: np.ndarray, distance_px: float) -> np.ndarray:
    """Points nearer than distance_px to one another become their mean."""
    rest = [*pixels]
    out = []
    while rest:
        group = [rest.pop()]
        near = [p for p in rest if np.linalg.norm(p - group[0]) < distance_px]
        rest = [p for p in rest if not np.linalg.norm(p - group[0]) < distance_px]
        out.append(np.mean(group + near, axis=0))
    return np.array(out).reshape(-1, 2)


def minimum_jerk(u: float) -> float:
    u = min(max(u, 0.0), 1.0)
    return u**3 * (10 - 15 * u + 6 * u * u)


def calm(t_s: float, seed: int = 0) -> np.ndarray:
    """Head sways, hands reach 0.3 m out and back in 2-3 s each way; (3, 3) [m]."""
    points = START_W.copy()
    points[0] += [
        0.02 * np.sin(0.7 * t_s),
        0.03 * np.sin(0.5 * t_s),
        0.01 * np.sin(0.9 * t_s),
    ]
    for hand in (1, 2):
        rng = np.random.default_rng([seed, hand])
        begin = rng.uniform(0.5, 2.0)
        while begin < t_s:
            out, pause = rng.uniform(2.0, 3.0), rng.uniform(0.3, 1.5)
            way = rng.normal(size=3) * [1.0, 0.6, 0.6]
            way *= 0.3 / np.linalg.norm(way)
            way[1] = np.sign(START_W[hand][1]) * max(abs(START_W[hand][1] + way[1]), 0.1)
            way[1] -= START_W[hand][1]
            gone = minimum_jerk((t_s - begin) / out)
            back = minimum_jerk((t_s - begin - out - pause) / out)
            points[hand] += way * (gone - back)
            begin += 2 * out + 2 * pause
    return points


def run_points(
    tracker: object,
    motion: Callable[[float], np.ndarray],
    seed: int,
    world: PointWorld | None = None,
    frames: int = 90,
    dt_s: float = DT_S,
) -> tuple[np.ndarray, np.ndarray, list[Estimates]]:
    """Truth (frames, T, 3), estimates (frames, T, 3) and the records."""
    world = world or PointWorld()
    rng = np.random.default_rng(seed)
    state = tracker.start_at(motion(0.0))
    truth, positions, records = [], [], []
    for k in range(1, frames + 1):
        points = motion(k * dt_s)
        state, estimates = tracker.step(state, world.see(tracker.cameras, points, rng), dt_s)
        truth.append(points)
        positions.append(estimates.positions_m)
        records.append(estimates)
    return np.array(truth), np.array(positions), records


@st.composite
def association_cases(draw: st.DrawFn, most: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """likelihood (m, T) in 1e-6..1 and gates."""
    m, T = draw(st.integers(0, most)), draw(st.integers(1, 4))
    logs = draw(hnp.arrays(float, (m, T), elements=st.floats(-14, 0)))
    gated = draw(hnp.arrays(bool, (m, T)))
    return np.exp(logs), gated
