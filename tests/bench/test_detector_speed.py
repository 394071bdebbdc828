"""How long the detector takes; ratios within one run, which no machine's load changes much.

Run with --benchmark-enable. Nothing here fails by the clock.
"""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.frames import StereoFrame
from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import PRESETS

WIDTH, HEIGHT = 640, 480
K = np.array([[540.0, 0, 319.5], [0, 540.0, 239.5], [0, 0, 1]])
SKIN, WOOD = (112.0, 145.0, 204.0), (57.0, 81.0, 115.0)  # BGR


def picture(seed: int, person: bool) -> np.ndarray:
    """A wall, a wooden table as wide as the picture, a head and two hands, sensor noise."""
    scene = np.full((HEIGHT, WIDTH, 3), 150.0)
    scene[300:] = WOOD
    if person:
        for centre, axes in (
            ((310, 105), (34, 45)),
            ((150, 331), (17, 26)),
            ((470, 345), (16, 24)),
        ):
            cv2.ellipse(scene, centre, axes, 0, 0, 360, SKIN, -1)
    noisy = scene + np.random.default_rng(seed).normal(0, 3, scene.shape)
    return np.clip(noisy, 0, 255).round().astype(np.uint8)


@pytest.fixture(scope="module")
def detector():
    camera = Camera(K, np.eye(3), np.zeros(3), WIDTH, HEIGHT)
    empty = (StereoFrame(i, i / 3, (picture(i, False),)) for i in range(10))
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # per picture on one core
    yield SkinDetector((camera,), PRESETS["thesis"].detector).learn(empty)
    cv2.setNumThreads(threads)


@pytest.mark.benchmark(group="detector, 640x480, one core")
@pytest.mark.parametrize(
    "change",
    [{}, {"subsample": 1}, {"components_compete": False}, {"shadow_min": 1.0}],
    ids=["thesis preset", "every pixel", "k-means alone", "no shadow rule"],
)
def test_one_picture(benchmark, detector, change):
    parameters = with_values(detector.parameters, change)
    variant = dataclasses.replace(detector, parameters=parameters)
    frame = StereoFrame(0, 0.0, (picture(99, True),))
    (blobs,) = benchmark(variant, frame)
    assert len(blobs) >= 3


@pytest.mark.benchmark(group="detector, learning")
def test_one_background_picture(benchmark, detector):
    frames = [StereoFrame(i, i / 3, (picture(i, False),)) for i in range(10)]
    benchmark.pedantic(detector.learn, (frames,), rounds=3)
