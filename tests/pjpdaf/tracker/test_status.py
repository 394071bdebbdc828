"""Status of the targets: tracked, coasting, lost."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from strategies import DT_S, START_W, PointWorld, rig

from pjpdaf.interfaces import Detections
from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.filter import PJPDAF

CAMERAS = rig().cameras
THESIS = PRESETS["thesis"].tracker
CLEAN = PointWorld(noise_px=0.0, miss=0.0, clutter=0.0)
ALONE = with_values(THESIS, {"p_detect": 0.999, "clutter": 1e-6, "occlusion": "none"})


def look(points: np.ndarray, world: PointWorld = CLEAN, seed: int = 0) -> tuple[Detections, ...]:
    return world.see(CAMERAS, points, np.random.default_rng(seed))


def eigenvalues(covariances: np.ndarray) -> np.ndarray:
    return np.linalg.eigvalsh(covariances)


def test_an_undetected_target_coasts_and_its_covariance_grows() -> None:
    tracker = PJPDAF(CAMERAS, THESIS)
    state = tracker.start_at(START_W)
    for _ in range(5):
        state, estimates = tracker.step(state, look(START_W), DT_S)
    assert estimates.status == ("tracked",) * 3
    widths = [eigenvalues(estimates.covariances_m2[2])]
    statuses = []
    for _ in range(4):
        state, estimates = tracker.step(state, look(START_W[:2]), DT_S)
        widths.append(eigenvalues(estimates.covariances_m2[2]))
        statuses.append(estimates.status[2])
        assert estimates.status[:2] == ("tracked",) * 2
    assert all(np.all(later > earlier) for earlier, later in pairwise(widths))
    assert statuses == ["coasting", "coasting", "lost", "lost"]
    state, estimates = tracker.step(state, look(START_W), DT_S)
    assert estimates.status == ("tracked",) * 3  # found again inside its gate


def test_a_wide_covariance_is_lost_whatever_the_clock() -> None:
    tracker = PJPDAF(CAMERAS, with_values(THESIS, {"lost_after_s": 1e6, "lost_sd_m": 0.3}))
    state = tracker.start_at(START_W)
    for _ in range(60):
        state, estimates = tracker.step(state, (Detections.none(),) * 2, DT_S)
    assert estimates.status == ("lost",) * 3
