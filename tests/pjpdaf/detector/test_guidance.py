"""Detections are the same wherever their scopes hold, and are not kept where they would differ."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera
from pjpdaf.detector.adaptation import BlobDetectorParameters
from pjpdaf.detector.blob_detector import BlobDetector
from pjpdaf.detector.components import ComponentParameters
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.detector.face import ExpectedHead, HeadPlace
from pjpdaf.detector.guidance import ANY, Guidance, Scope, ScopedDetector
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates

K = np.array([[270.0, 0, 159.5], [0, 270.0, 119.5], [0, 0, 1]])
CAMERAS = tuple(Camera(K, np.eye(3), np.array([x, 0.0, 0.0]), 320, 240) for x in (0.06, -0.06))
SKIN_BGR, PINK_BGR, SHIRT_BGR = (110, 140, 204), (140, 120, 220), (128, 80, 51)
SPECKS = ((40, 40, 2), (40, 60, 3), (40, 80, 4), (60, 40, 5), (60, 60, 6))


def picture(rng: np.random.Generator, shift_px: int = 0, person: bool = True) -> np.ndarray:
    """A person with specks of skin, and a hand that is raised above a face of another colour."""
    scene = np.full((240, 320, 3), 150.0)
    if person:
        cv2.rectangle(scene, (115 + shift_px, 90), (200 + shift_px, 165), SHIRT_BGR, -1)
        cv2.ellipse(scene, (158 + shift_px, 60), (17, 22), 0, 0, 360, PINK_BGR, -1)
        cv2.ellipse(scene, (170 + shift_px, 24), (10, 14), 0, 0, 360, SKIN_BGR, -1)
        cv2.ellipse(scene, (235 + shift_px, 172), (8, 12), 0, 0, 360, SKIN_BGR, -1)
        for x, y, radius in SPECKS:
            cv2.circle(scene, (x + shift_px, y), radius, SKIN_BGR, -1)
    return np.clip(scene + rng.normal(0, 2, scene.shape), 0, 255).round().astype(np.uint8)


def frame(seed: int, person: bool = True) -> StereoFrame:
    rng = np.random.default_rng(seed)
    return StereoFrame(0, 0.0, tuple(picture(rng, shift, person) for shift in (0, -20)))


def predicted(rng: np.random.Generator) -> Estimates | None:
    """A prediction of anything: near the head or not, at any depth, tracked or not; or none."""
    if rng.random() < 0.1:
        return None
    none = Estimates.waiting()
    positions = np.array([0.0, -0.25, 1.2]) + rng.normal(0, 0.01, (3, 3))
    positions[0] += rng.choice([0.0, 0.05, 0.4]) * rng.normal(0, 1, 3)
    positions[:, 2] *= rng.choice([0.5, 1.0, 1.8])
    status = tuple(rng.choice(["tracked", "tracked", "lost"], 3).tolist())
    return replace(none, positions_m=positions, status=status)


def flat(detections: tuple[Detections, ...]) -> list[bytes]:
    """All of the detections, byte for byte."""
    values = []
    for view in detections:
        values += [view.centres_px, view.covariances_px2, view.ellipses, view.areas_px]
        if view.looks is not None:
            values += [*view.looks.pixels, view.looks.palms, view.looks.fingers]
            values.append(view.looks.silhouette.classes)
    return [value.tobytes() for value in values]


DETECTORS = {
    "blobs": BlobDetector.of(CAMERAS, BlobDetectorParameters()),
    "clusters": SkinDetector(
        CAMERAS, DetectorParameters(components=ComponentParameters(min_area_px=200.0))
    ),
}


@pytest.mark.parametrize("name", DETECTORS)
def test_detections_are_the_same_wherever_all_scopes_hold(name):
    detector = DETECTORS[name].learn(frame(seed, person=False) for seed in range(10))
    assert isinstance(detector, ScopedDetector)
    seen = frame(99)
    rng = np.random.default_rng(4)
    answers = []
    for _ in range(20):
        prediction = predicted(rng)
        detections, scopes = detector.detect(seen, prediction)
        # A detector that has learnt nothing takes the same from a prediction.
        guidance = DETECTORS[name].guidance(prediction)
        assert all(scope.holds(one) for scope, one in zip(scopes, guidance, strict=True))
        answers.append((flat(detections), scopes, guidance))
    held = others = 0
    for one, scopes, _ in answers:
        for other, _, guidance in answers:
            if all(scope.holds(g) for scope, g in zip(scopes, guidance, strict=True)):
                held += 1
                assert one == other
            else:
                others += one != other
    assert held > 2 * len(answers)  # and not only where the predictions are the same
    assert others > 20  # and what does not hold would be wrong


def test_a_missing_picture_is_missing_for_any_prediction():
    detector = DETECTORS["blobs"]
    _, scopes = detector.detect(StereoFrame(0, 0.0, (None, None)))
    assert scopes == (ANY, ANY)


def test_the_place_of_a_head_serves_predictions_that_lead_to_it():
    at_top = ExpectedHead(np.array([80.0, 40.0]), 100.0)
    aside = ExpectedHead(np.array([20.0, 90.0]), 100.0)
    same_box = ExpectedHead(np.array([20.1, 90.1]), 100.0)
    top, nobody = HeadPlace((82.0, 41.0)), HeadPlace()
    elsewhere = HeadPlace((82.0, 41.0), aside.box())
    assert [top.serves(head) for head in (None, at_top, aside)] == [True, True, False]
    assert [nobody.serves(head) for head in (None, at_top)] == [True, False]
    served = [elsewhere.serves(head) for head in (None, at_top, aside, same_box)]
    assert served == [False, False, True, True]
    far = ExpectedHead(np.array([30.0, 90.0]), 100.0)
    assert not elsewhere.serves(far)


def test_a_smallest_area_holds_between_the_areas_that_were_compared():
    scope = Scope(20.0, 50.0)
    assert [scope.holds(Guidance(area)) for area in (20.0, 20.5, 50.0, 50.5)] == [
        False,
        True,
        True,
        False,
    ]
