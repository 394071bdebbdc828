"""Blob detector and silhouette on drawn scenes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera
from pjpdaf.detector.adaptation import AdaptationParameters, BlobDetectorParameters
from pjpdaf.detector.blob_detector import BlobDetector, directions
from pjpdaf.detector.components import segments
from pjpdaf.detector.detector import numbered
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.silhouette import reduced, reduction
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.looks import BACKGROUND, CLOTHED, SKIN, looks_of_ellipses

K = np.array([[540.0, 0, 319.5], [0, 540.0, 239.5], [0, 0, 1]])
CAMERA = Camera(K, np.eye(3), np.zeros(3), 640, 480)
NOTHING_ADAPTS = BlobDetectorParameters(
    adaptation=AdaptationParameters(False, False, False, False, False)
)
SKIN_BGR, SHIRT_BGR = (110, 140, 204), (128, 80, 51)


def picture(rng: np.random.Generator, person: bool = True) -> np.ndarray:
    scene = np.full((480, 640, 3), 150.0)
    if person:
        cv2.rectangle(scene, (230, 180), (400, 330), SHIRT_BGR, -1)
        cv2.ellipse(scene, (315, 110), (34, 45), 0, 0, 360, SKIN_BGR, -1)
        cv2.ellipse(scene, (150, 330), (17, 26), 0, 0, 360, SKIN_BGR, -1)
        cv2.ellipse(scene, (470, 345), (16, 24), 0, 0, 360, SKIN_BGR, -1)
    return np.clip(scene + rng.normal(0, 3, scene.shape), 0, 255).round().astype(np.uint8)


def frame(*pictures: np.ndarray | None) -> StereoFrame:
    return StereoFrame(0, 0.0, pictures)


@pytest.fixture(scope="module")
def detector() -> BlobDetector:
    rng = np.random.default_rng(5)
    empty = (frame(picture(rng, person=False)) for _ in range(12))
    return BlobDetector.of((CAMERA,), DetectorParameters()).learn(empty)


def test_each_blob_has_the_pixels_that_make_up_its_area(detector):
    (seen,) = detector(frame(picture(np.random.default_rng(6))))
    assert len(seen) == 3
    looks = seen.looks
    for centre, area, pixels in zip(seen.centres_px, seen.areas_px, looks.pixels, strict=True):
        np.testing.assert_allclose(pixels.mean(axis=0), centre, atol=0.7)
        assert len(pixels) * looks.pixel_area_px == pytest.approx(area, rel=0.1)
    assert np.abs(looks.palms).max() < 0.08  # ellipses point nowhere


def test_silhouette_tells_shirt_from_skin_from_wall(detector):
    (seen,) = detector(frame(picture(np.random.default_rng(7))))
    shape = seen.looks.silhouette
    assert shape.step_px == 4
    assert shape.classes.shape == (120, 160)
    at = lambda x, y: shape.classes[y // 4, x // 4]  # noqa: E731
    assert (at(315, 250), at(315, 110), at(150, 330), at(60, 60)) == (
        CLOTHED,
        SKIN,
        SKIN,
        BACKGROUND,
    )
    assert (shape.classes == CLOTHED).mean() == pytest.approx(171 * 151 / (640 * 480), rel=0.1)


def test_missing_picture_is_missing_and_wrong_size_refused(detector):
    (seen,) = detector(frame(None))
    assert seen.missing
    with pytest.raises(BenchError, match="320x240"):
        detector(frame(np.zeros((240, 320, 3), np.uint8)))


def hand(wrist: bool) -> np.ndarray:
    mask = np.zeros((200, 200), np.uint8)
    cv2.circle(mask, (60, 100), 22, 255, -1)
    if wrist:
        cv2.rectangle(mask, (60, 86), (110, 114), 255, -1)
    else:
        for y in (86, 96, 106, 116):
            cv2.line(mask, (60, y), (120, y), 255, 4)
    return mask


@pytest.mark.parametrize("wrist", [False, True])
def test_centroid_is_off_the_palm_towards_fingers_or_wrist(wrist):
    seen = segments(hand(wrist), 100.0, merge_fragments=False)
    (palm,), (finger,) = directions(seen, numbered(seen))
    assert palm[0] > 0.12
    assert abs(palm[1]) < 0.05
    if wrist:
        assert np.abs(finger).max() < 0.03  # a wrist is not thin
    else:
        assert finger[0] > 0.12


@pytest.mark.parametrize(("width", "step"), [(640, 4), (320, 2), (160, 1), (1280, 8), (100, 1)])
def test_pictures_of_any_size_are_reduced_to_about_one(width, step):
    assert reduction(width) == step
    assert reduced(np.zeros((90, width, 3), np.uint8)).shape[1] == width // step


def test_looks_of_an_ellipse_fill_it():
    looks = looks_of_ellipses(np.array([[100.0, 50.0, 40.0, 20.0, np.pi / 2]]))
    (pixels,) = looks.pixels
    np.testing.assert_allclose(pixels.mean(axis=0), [100, 50], atol=1e-9)
    step = looks.pixel_area_px**0.5
    for axis, length in ((1, 80), (0, 40)):
        assert length - 2 * step < np.ptp(pixels[:, axis]) <= length + 1e-9
    # A lattice counts an area to within half a step along the border.
    area, border = np.pi * 40 * 20, 2 * np.pi * 30
    assert abs(len(pixels) * looks.pixel_area_px - area) < border * step / 2
    assert len(pixels) > 100


@pytest.mark.parametrize("light", [(0.45, 0.92, 1.3), (1.5, 1.05, 0.9), (0.22, 0.22, 0.22)])
def test_head_and_hands_are_found_in_any_light(light):
    def lit(rng: np.random.Generator, person: bool) -> StereoFrame:
        clean = picture(rng, person).astype(np.float64) * light
        return frame(np.clip(clean + rng.normal(0, 3, clean.shape), 0, 255).astype(np.uint8))

    rng = np.random.default_rng(8)
    empty = [lit(rng, False) for _ in range(12)]
    shown = lit(rng, True)
    (plain,) = BlobDetector.of((CAMERA,), NOTHING_ADAPTS).learn(empty)(shown)
    (seen,) = BlobDetector.of((CAMERA,), BlobDetectorParameters()).learn(empty)(shown)
    assert len(plain) < 3
    assert len(seen) == 3
    order = np.argsort(seen.centres_px[:, 0])
    np.testing.assert_allclose(seen.centres_px[order], [(150, 330), (315, 110), (470, 345)], atol=3)
