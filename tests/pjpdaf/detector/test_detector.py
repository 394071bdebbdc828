"""The detector as a whole: drawn scenes with sensor noise, through skin, background and blobs."""

from __future__ import annotations

import dataclasses
import pickle

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera, distort_points
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.skin import learn_skin_range
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Detector
from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import PRESETS

WIDTH, HEIGHT = 640, 480
K = np.array([[540.0, 0, 319.5], [0, 540.0, 239.5], [0, 0, 1]])
SHAPES = (
    (310.3, 105.6, 34.0, 45.0),  # head: centre, semi-axes
    (150.2, 330.9, 17.0, 26.0),
    (470.7, 345.1, 16.0, 24.0),
)


def camera(*distortion: float) -> Camera:
    return Camera(K, np.eye(3), np.zeros(3), WIDTH, HEIGHT, np.array(distortion))


def colour(hue_deg: float, saturation: float, value: float) -> np.ndarray:
    hsv = np.array([[[hue_deg, saturation, value]]], np.float32)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0] * 255


SKIN, WOOD, SHIRT = colour(18, 0.45, 0.8), colour(25, 0.5, 0.45), colour(220, 0.6, 0.5)


def picture(
    rng: np.random.Generator, shapes=SHAPES, person: bool = True, shade: float = 0.7
) -> np.ndarray:
    """A wall, a wooden table and door, a person in a blue shirt whose shadow lies on the table."""
    scene = np.full((HEIGHT, WIDTH, 3), 150.0)
    scene[300:] = WOOD
    scene[40:300, 560:] = WOOD
    if person:
        scene[300:360, 180:460] *= shade
        scene[150:320, 230:400] = SHIRT
        y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
        for cx, cy, a, b in shapes:
            scene[((x - cx) / a) ** 2 + ((y - cy) / b) ** 2 <= 1] = SKIN
    noisy = scene + rng.normal(0, 3, scene.shape)
    return np.clip(noisy, 0, 255).round().astype(np.uint8)


def frame(*pictures: np.ndarray | None, index: int = 0) -> StereoFrame:
    return StereoFrame(index, index / 3, pictures)


def learnt(parameters: DetectorParameters, cam: Camera | None = None) -> SkinDetector:
    rng = np.random.default_rng(100)
    empty = (frame(picture(rng, person=False)) for _ in range(12))
    return SkinDetector((cam or camera(),), parameters, keep_masks=True).learn(empty)


@pytest.fixture(scope="module")
def detector() -> SkinDetector:
    return learnt(PRESETS["thesis"].detector)


def nearest(seen: Detections, shape) -> float:
    return float(np.linalg.norm(seen.centres_px - shape[:2], axis=1).min())


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_head_and_hands_are_found_at_their_centres(preset):
    """A_min of 500 px and all: every shape drawn here is larger. No shadow: the printed thesis has
    no rule against one.
    """
    seen = learnt(PRESETS[preset].detector)
    rng = np.random.default_rng(0)
    for _ in range(3):
        (blobs,) = seen(frame(picture(rng, shade=1.0)))
        assert len(blobs) == 3
        for shape in SHAPES:
            # The drawn rim is noisy, and opening and closing move it: a fifth of a pixel.
            assert nearest(blobs, shape) < 0.2


def test_the_record_is_complete(detector):
    (blobs,) = detector(frame(picture(np.random.default_rng(1))))
    order = np.argsort(blobs.centres_px[:, 1])
    for i, (_, _, a, b) in zip(order, SHAPES, strict=True):
        assert blobs.areas_px[i] == pytest.approx(np.pi * a * b, rel=0.03)
        np.testing.assert_allclose(blobs.ellipses[i, 2:4], (b, a), rtol=0.03)
        assert abs(np.sin(blobs.ellipses[i, 4])) > 0.99  # all drawn upright
    np.testing.assert_array_equal(blobs.ellipses[:, :2], blobs.centres_px)
    sd2 = detector.parameters.centre_sd_px**2
    np.testing.assert_allclose(blobs.covariances_px2, [sd2 * np.eye(2)] * 3)
    assert not blobs.missing
    assert blobs.mask is not None
    assert blobs.mask.shape == (HEIGHT, WIDTH)
    assert (blobs.mask > 0).sum() == blobs.areas_px.sum()


def test_it_is_a_detector(detector):
    plugged: Detector = detector
    assert plugged is detector


def test_without_a_background_the_wood_is_taken_for_skin():
    bare = SkinDetector((camera(),), DetectorParameters())
    (blobs,) = bare(frame(picture(np.random.default_rng(2), person=False)))
    assert len(blobs) >= 1
    assert blobs.areas_px.max() > 50_000
    assert blobs.mask is None


def test_an_empty_scene_has_no_detections(detector):
    (blobs,) = detector(frame(picture(np.random.default_rng(3), person=False)))
    assert len(blobs) == 0
    assert not blobs.missing
    assert blobs.mask is not None
    assert not blobs.mask.any()


def test_a_missing_picture_is_missing_and_not_absent(detector):
    pair = dataclasses.replace(
        detector, cameras=(camera(), camera()), backgrounds=detector.backgrounds * 2
    )
    seen, missing = pair(frame(picture(np.random.default_rng(4)), None))
    assert len(seen) == 3
    assert not seen.missing
    assert len(missing) == 0
    assert missing.missing


def test_the_same_picture_gives_the_same_bytes(detector):
    shot = picture(np.random.default_rng(5))

    def answer() -> list[bytes]:
        (blobs,) = detector(frame(shot))
        return [
            a.tobytes()
            for a in (
                blobs.centres_px,
                blobs.covariances_px2,
                blobs.ellipses,
                blobs.areas_px,
            )
        ]

    first = answer()
    detector(frame(picture(np.random.default_rng(6), SHAPES[:2])))
    cv2.setRNGSeed(123)
    assert answer() == first


def test_a_shadow_on_the_table_is_no_blob(detector):
    rng = np.random.default_rng(7)
    (with_rule,) = detector(frame(picture(rng)))
    parameters = with_values(detector.parameters, {"shadow_min": 1.0})
    without = dataclasses.replace(detector, parameters=parameters)
    (plain,) = without(frame(picture(rng)))
    assert len(with_rule) == 3
    assert plain.areas_px.sum() > 1.5 * with_rule.areas_px.sum()


def test_one_pixel_in_16_gives_the_same_detections(detector):
    rng = np.random.default_rng(8)
    parameters = with_values(detector.parameters, {"subsample": 1})
    full = dataclasses.replace(detector, parameters=parameters)
    for _ in range(5):
        shot = frame(picture(rng))
        np.testing.assert_array_equal(full(shot)[0].centres_px, detector(shot)[0].centres_px)


@pytest.mark.parametrize("how", ["points", "picture"])
def test_centres_are_in_the_undistorted_picture(how):
    """Both ways of undistorting find the shapes where the ideal pinhole has them."""
    lens = camera(-0.22, 0.06, 0.001, -0.001, 0.0)
    parameters = with_values(DetectorParameters(), {"undistort": how})
    seen = learnt(parameters, lens)
    # Drawn through the lens: a pixel of the real picture shows its undistorted place.
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    ideal = cv2.undistortPoints(
        np.stack([x, y], -1).reshape(-1, 1, 2).astype(float), K, lens.distortion.copy(), P=K
    ).reshape(HEIGHT, WIDTH, 2)
    rng = np.random.default_rng(9)
    shot = picture(rng, ()).astype(float)
    for cx, cy, a, b in SHAPES:
        inside = ((ideal[..., 0] - cx) / a) ** 2 + ((ideal[..., 1] - cy) / b) ** 2 <= 1
        shot[inside] = SKIN
    (blobs,) = seen(frame(shot.round().astype(np.uint8)))
    assert len(blobs) == 3
    for shape in SHAPES:
        assert nearest(blobs, shape) < 0.3
        moved = distort_points(lens, np.array([shape[:2]]))[0] - shape[:2]
        if shape is not SHAPES[0]:
            assert np.linalg.norm(moved) > 1.0  # so the test can fail


def test_a_detector_crosses_processes_and_detects_alike(detector):
    again = pickle.loads(pickle.dumps(detector))
    shot = frame(picture(np.random.default_rng(10)))
    np.testing.assert_array_equal(again(shot)[0].centres_px, detector(shot)[0].centres_px)


def test_learning_skips_missing_pictures_and_wants_enough_of_each_view():
    rng = np.random.default_rng(11)
    shots = [picture(rng, person=False) for _ in range(10)]
    pair = SkinDetector((camera(), camera()), DetectorParameters())
    frames = [frame(shot, shot if i else None, index=i) for i, shot in enumerate(shots)]
    with pytest.raises(BenchError, match="at least 10 person-free frames, got 9"):
        pair.learn(frames)
    assert pair.learn([*frames, frame(None, shots[0])]).backgrounds[1].frames == 10
    assert pair.backgrounds == ()


def test_a_wrong_picture_is_one_line(detector):
    for bad, words in (
        (
            np.zeros((240, 320, 3), np.uint8),
            "view 0: the picture is 320x240 px, the camera 640x480",
        ),
        (np.zeros((HEIGHT, WIDTH), np.uint8), r"must be uint8 BGR \(h, w, 3\), got uint8"),
        (np.zeros((HEIGHT, WIDTH, 3)), "got float64"),
    ):
        with pytest.raises(BenchError, match=words) as fault:
            detector(frame(bad, index=7))
        assert "Frame 7" in str(fault.value)
        assert "\n" not in str(fault.value)
    with pytest.raises(BenchError, match="Frame 0 has 2 pictures, the rig 1 cameras"):
        detector(frame(None, None))


def test_a_background_of_another_rig_is_refused(detector):
    with pytest.raises(BenchError, match="2 cameras but 1 backgrounds"):
        dataclasses.replace(detector, cameras=(camera(), camera()))
    small = Camera(K, np.eye(3), np.zeros(3), 320, 240)
    with pytest.raises(BenchError, match="the background is 640x480 px, the camera 320x240"):
        dataclasses.replace(detector, cameras=(small,))


def test_a_learnt_skin_range_is_used():
    green = colour(120, 0.6, 0.7)
    sample = np.tile(green, (20, 20, 1)).round().astype(np.uint8)
    parameters = DetectorParameters(skin=learn_skin_range(sample))
    shot = np.full((HEIGHT, WIDTH, 3), 150, np.uint8)
    shot[100:140, 200:260] = green
    shot[300:340, 200:260] = SKIN
    (blobs,) = SkinDetector((camera(),), parameters)(frame(shot))
    np.testing.assert_allclose(blobs.centres_px, [[229.5, 119.5]], atol=0.1)
