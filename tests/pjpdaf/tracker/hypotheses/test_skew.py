"""Views of different moments: learnt from moving hands, and taken out."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.interfaces import Detections
from pjpdaf.tracker.hypotheses.geometry import Views
from pjpdaf.tracker.hypotheses.parameters import (
    HypothesisParameters,
    NoiseParameters,
    OffsetParameters,
)
from pjpdaf.tracker.hypotheses.skew import GRID_S, Skew, Skewed, shifts
from pjpdaf.tracker.hypotheses.tracker import HypothesisState, HypothesisTracker
from tests.strategies import START_W, detections, rig

CAMERAS = rig().cameras
AREAS_PX = np.array([4500.0, 1500, 1500])
NONE = (0.0, 0.0, 0.0)
DT_S, FRAMES = 0.1, 40


def places(time_s: float) -> np.ndarray:
    """Both hands on slow circles before the person."""
    angle = 2.0 * time_s
    circle = 0.12 * np.array([0.0, np.sin(angle), np.cos(angle) - 1.0])
    return START_W + np.array([np.zeros(3), circle, -circle])


def seen(time_s: float, skew_s: float) -> tuple[Detections, ...]:
    moments = time_s, time_s + skew_s
    return tuple(
        detections(project(camera, places(moment)), AREAS_PX)
        for camera, moment in zip(CAMERAS, moments, strict=True)
    )


def followed(skew_s: float, learn_skew: bool = True) -> tuple[HypothesisState, float]:
    """State after all frames, and the largest error of a hand in the second half [m]."""
    parameters = HypothesisParameters(
        offsets=OffsetParameters(NONE, NONE), noise=NoiseParameters(learn_skew=learn_skew)
    )
    tracker = HypothesisTracker(CAMERAS, parameters)
    state = tracker.start(seen(0.0, skew_s))
    assert state is not None
    errors = []
    for frame in range(1, FRAMES):
        time_s = frame * DT_S
        state, estimates = tracker.step(state, seen(time_s, skew_s), DT_S)
        off = estimates.positions_m[1:] - places(time_s)[1:]
        errors.append(float(np.linalg.norm(off, axis=1).max()))
    return state, max(errors[FRAMES // 2 :])


@pytest.mark.parametrize("skew_s", [0.05, -0.03])
def test_skew_is_learnt_and_taken_out(skew_s):
    state, error_m = followed(skew_s)
    assert state.skew is not None
    assert state.skew.seconds == pytest.approx(skew_s, abs=0.01)
    assert error_m < 0.06
    assert followed(skew_s, learn_skew=False)[1] > 2 * error_m


def test_cameras_of_one_moment_have_none():
    state, _ = followed(0.0)
    assert state.skew is not None
    assert state.skew.seconds == 0.0


def test_few_noisy_sightings_make_no_skew():
    noise = np.random.default_rng(1).normal(0.0, 1.0, 20)
    speeds = np.linspace(-200.0, 200.0, 20)
    assert Skew(1.0).after(noise, speeds, DT_S).seconds == 0.0


def test_skew_is_bounded():
    speeds = np.full(50, 200.0)
    assert Skew(1.0).after(0.12 * speeds, speeds, DT_S).seconds == 0.1


def test_a_hand_that_turned_is_put_back_by_what_it_shows_across_the_lines():
    views, before = Views.of(CAMERAS), places(0.0)[1:2]
    known = Skew(1.0, -0.5 * ((GRID_S - 0.05) / 0.004) ** 2)
    assert known.seconds == pytest.approx(0.05)
    assert known.spread_s == pytest.approx(0.004, rel=0.05)
    # It rose by 60 mm since the frame before and sinks at this moment.
    now = np.add(before, (0.0, 0.0, 0.06))
    left, right = views.project(now)[0][0], views.project(np.subtract(now, (0.0, 0.0, 0.02)))[0][1]
    skewed, whole = Skewed(known, before, 1 / 3), np.array([True])
    r_px = shifts(views, left, right, before, 1 / 3).r_px
    moved, sd_px = skewed.undone(views, left, right, whole)
    assert abs(shifts(views, left, moved, before, 1 / 3).r_px) < 0.2 * abs(r_px)
    assert 1.0 < sd_px[0] < 5.0  # along the lines nothing showed its speed
    untouched, none_px = skewed.undone(views, left, right, ~whole)
    np.testing.assert_array_equal(untouched, right)
    assert none_px[0] == 0.0
