"""Signs that tracks are of other frames than they say."""

from types import SimpleNamespace

import numpy as np
import pytest

from pjpdaf.interfaces import Estimates
from scenarios.tracks.estimates import frame_shift


def sequence_and_tracks(shift, frames=20, amplitude_m=0.15, noise_m=0.01):
    t = np.arange(-2, frames + 2)
    path = np.zeros((len(t), 3, 3))
    path[:, 1, 1] = amplitude_m * np.sin(0.6 * t)
    path[:, 2, 2] = amplitude_m * np.cos(0.5 * t)
    noise = np.random.default_rng(0).normal(0, noise_m, path.shape)
    truths = [SimpleNamespace(centres_m=centres) for centres in path[2:-2]]
    said = (path + noise)[2 + shift : len(t) - 2 + shift]
    tracked = ("tracked",) * 3
    nan = np.full((3, 3, 3), np.nan)
    estimates = [Estimates(p, nan, np.zeros((3, 3)), tracked) for p in said]
    return SimpleNamespace(truths=truths), estimates


@pytest.mark.parametrize("shift", [-1, 1])
def test_tracks_of_the_frame_before_or_after_are_recognised(shift):
    found = frame_shift(*sequence_and_tracks(shift))
    assert found is not None
    assert found.frames == shift
    assert found.then_mm < 25 < 45 < found.now_mm


def test_no_doubt_where_the_frames_are_right_or_nothing_moves():
    assert frame_shift(*sequence_and_tracks(0)) is None
    assert frame_shift(*sequence_and_tracks(0, noise_m=0.1)) is None
    assert frame_shift(*sequence_and_tracks(1, amplitude_m=0.01)) is None
    assert frame_shift(*sequence_and_tracks(1, frames=5)) is None
