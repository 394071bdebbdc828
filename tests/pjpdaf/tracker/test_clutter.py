"""Readings of the clutter."""

from __future__ import annotations

import numpy as np
from strategies import DT_S, START_W, PointWorld, rig

from pjpdaf.interfaces import Detections
from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.clutter import Density, Relative
from pjpdaf.tracker.filter import PJPDAF

CAMERAS = rig().cameras
THESIS = PRESETS["thesis"].tracker
CLEAN = PointWorld(noise_px=0.0, miss=0.0, clutter=0.0)
ALONE = with_values(THESIS, {"p_detect": 0.999, "clutter": 1e-6, "occlusion": "none"})


def look(points: np.ndarray, world: PointWorld = CLEAN, seed: int = 0) -> tuple[Detections, ...]:
    return world.see(CAMERAS, points, np.random.default_rng(seed))


def test_a_density_and_its_count_per_image_are_one_reading() -> None:
    area = CAMERAS[0].width_px * CAMERAS[0].height_px
    seen = look(START_W, PointWorld(2.0, 0.0, 2.0))
    results = []
    for reading, clutter in (("density", 0.2 / area), ("area", 0.2)):
        p = with_values(THESIS, {"clutter_reading": reading, "clutter": clutter})
        tracker = PJPDAF(CAMERAS, p)
        results.append(tracker.step(tracker.start_at(START_W), seen, DT_S)[1].positions_m)
    np.testing.assert_allclose(*results)


def test_likelihoods_by_hand() -> None:
    """d^2 = 2 in a gate, S = 4 I: exp(-1), over 2 pi 4 as a density; 0 outside the gate."""
    d2, gated = np.array([[2.0, 2.0]]), np.array([[True, False]])
    S = np.tile(4.0 * np.eye(2), (2, 1, 1))
    np.testing.assert_allclose(Relative().likelihood(d2, gated, S), [[np.exp(-1), 0.0]])
    density = np.exp(-1) / (2 * np.pi * 4)
    np.testing.assert_allclose(Density().likelihood(d2, gated, S), [[density, 0.0]])
    camera = CAMERAS[0]
    area = camera.width_px * camera.height_px
    assert Density().level(0.1, camera) == Relative().level(0.1, camera) == 0.1
    assert Density(per_image=True).level(0.1, camera) == 0.1 / area
