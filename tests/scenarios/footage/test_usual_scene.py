"""The person-free scene from footage in which the person moves."""

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from scenarios.footage.usual_scene import LEARNT, usual_frames

SKIN, WALL = (90, 120, 190), (120, 130, 125)  # BGR


def footage(count, moving=True):
    """A wall with noise, and a block of skin that covers each pixel for a quarter of the time."""
    rng = np.random.default_rng(1)
    for k in range(count):
        picture = np.full((40, 60, 3), WALL, np.float64)
        x = 10 * (k % 5) if moving else 20
        picture[10:25, x : x + 15] = SKIN
        noisy = np.clip(picture + rng.normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
        yield StereoFrame(k, k / 3, (noisy, None if k % 7 == 0 else noisy))


@pytest.mark.parametrize("total", [40, None, 400])
def test_what_moves_is_not_background(total):
    learnt, parts = usual_frames(footage(40 if total != 400 else 200), total)
    assert len(learnt) == LEARNT
    for view in (0, 1):
        pictures = np.stack([frame.pictures[view] for frame in learnt]).astype(float)
        assert np.abs(pictures.mean(axis=0) - WALL).max() < 10  # the wall is 60 from skin
        assert 0.5 < pictures.std(axis=0).mean() < 3  # of the noise, which has 2
    assert parts == 0


def test_a_head_that_rests_is_no_background_but_a_wall_is(monkeypatch):
    monkeypatch.setattr("scenarios.footage.usual_scene.HEAD_SHARE", 0.2)  # of 60 x 40 pixels
    learnt, parts = usual_frames(footage(40, moving=False), 40)
    assert parts == 2  # in both views
    assert np.abs(learnt[0].pictures[0][15, 25].astype(int) - SKIN).min() > 15
    assert np.abs(learnt[0].pictures[0][35, 5].astype(int) - WALL).max() < 10
    monkeypatch.setattr("scenarios.footage.usual_scene.HEAD_SHARE", 0.02)
    learnt, parts = usual_frames(footage(40, moving=False), 40)
    assert parts == 0
    assert np.abs(learnt[0].pictures[0][15, 25].astype(int) - SKIN).max() < 10


def test_too_short_footage():
    with pytest.raises(BenchError, match="needs at least 20 pictures of each view, got 17"):
        usual_frames(footage(20), 20)
