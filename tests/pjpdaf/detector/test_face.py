"""Colour of the face, and pictures balanced to it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pjpdaf.detector.face import (
    REFERENCE_BGR,
    ExpectedHead,
    Face,
    face_in,
    head_place,
    mean_face,
    to_reference,
)

FOCAL_PX = 135.0  # of a picture 160 px wide
GREY = np.zeros(2)
LIGHTS = {
    "neutral": (1.0, 1.0, 1.0),
    "warm": (0.45, 0.92, 1.3),
    "cold": (1.5, 1.05, 0.9),
    "dim": (0.35, 0.35, 0.35),
}


def face_of(small, foreground, chroma, focal_px, expected=None, to_shoulders=True) -> Face | None:
    _, inside = head_place(foreground, focal_px, expected, to_shoulders)
    return None if inside is None else face_in(inside, small, chroma)


def person(
    skin_bgr, shirt_bgr=(128, 80, 51), hair_bgr=(30, 35, 45)
) -> tuple[np.ndarray, np.ndarray]:
    scene = np.full((120, 160, 3), 120, np.uint8)
    for colour, draw in (
        (shirt_bgr, lambda at, c: cv2.rectangle(at, (55, 52), (105, 90), c, -1)),
        (hair_bgr, lambda at, c: cv2.ellipse(at, (80, 33), (9, 14), 0, 0, 360, c, -1)),
        (skin_bgr, lambda at, c: cv2.ellipse(at, (80, 39), (8, 11), 0, 0, 360, c, -1)),
    ):
        draw(scene, colour)
    mask = (np.abs(scene.astype(int) - 120).max(axis=2) > 0).astype(np.uint8)
    mask[51] = 0  # the collar is missing: head and body are two components
    return scene, mask


@pytest.mark.parametrize("light", LIGHTS)
def test_the_faces_colour_in_any_light_and_the_picture_in_the_reference_light(light):
    gains = np.array(LIGHTS[light])
    skin = tuple(np.clip(np.array(REFERENCE_BGR) * gains, 0, 255).round().tolist())
    scene, mask = person(skin)
    scene_chroma = np.array([np.log(gains[2] / gains[1]), np.log(gains[1] / gains[0])])
    face = face_of(scene, mask, scene_chroma, FOCAL_PX)
    assert face is not None
    np.testing.assert_allclose(face.bgr, skin, atol=2)
    assert face.fits == (light == "neutral")
    np.testing.assert_allclose(to_reference(scene, face)[39, 80], REFERENCE_BGR, atol=2)


def test_a_blue_head_is_no_face():
    scene, mask = person((128, 80, 51), hair_bgr=(110, 70, 45))
    assert face_of(scene, mask, GREY, FOCAL_PX) is None


def test_no_person_no_face():
    scene, _ = person(REFERENCE_BGR)
    assert face_of(scene, np.zeros((120, 160), np.uint8), GREY, FOCAL_PX) is None


def test_a_taller_person_behind_is_not_the_face_that_is_expected():
    """Their silhouettes touch, so that the top is the stranger's."""
    scene, mask = person(REFERENCE_BGR)
    stranger = (40, 60, 90)
    cv2.rectangle(scene, (110, 4), (150, 100), (60, 90, 40), -1)
    cv2.ellipse(scene, (128, 14), (7, 10), 0, 0, 360, stranger, -1)
    cv2.rectangle(mask, (106, 4), (150, 100), 1, -1)
    expected = ExpectedHead(np.array([80.0, 39.0]), FOCAL_PX / 1.3)
    alone = face_of(scene, mask, GREY, FOCAL_PX)
    assert alone is not None
    np.testing.assert_allclose(alone.bgr, stranger, atol=2)
    face = face_of(scene, mask, GREY, FOCAL_PX, expected)
    assert face is not None
    np.testing.assert_allclose(face.bgr, REFERENCE_BGR, atol=2)


def test_the_views_faces_are_averaged_by_size():
    one, two = Face(np.array([10.0, 20.0, 30.0]), 100), Face(np.array([20.0, 30.0, 40.0]), 300)
    mean = mean_face([one, two])
    np.testing.assert_allclose(mean.bgr, [17.5, 27.5, 37.5])
    assert mean_face([]) is None


@pytest.mark.parametrize(
    ("bgr", "fits"),
    [((79, 101, 142), True), ((34, 85, 171), False), ((97, 95, 112), False), ((29, 37, 52), False)],
)
def test_faces_that_the_fixed_range_holds(bgr, fits):
    assert Face(np.array(bgr, float), 9).fits is fits


def test_the_shirt_below_the_chin_is_not_the_face():
    """Of a person far away a head's usual height reaches down to a shirt of a colour near skin."""
    shirt = (70, 120, 180)
    scene, mask = person(REFERENCE_BGR, shirt, hair_bgr=(30, 35, 45))
    mask[51, 74:87] = 1
    far_px = 2.2 * FOCAL_PX
    face = face_of(scene, mask, GREY, far_px)
    assert face is not None
    np.testing.assert_allclose(face.bgr, REFERENCE_BGR, atol=2)
    deeper = face_of(scene, mask, GREY, far_px, to_shoulders=False)
    assert deeper is not None
    np.testing.assert_allclose(deeper.bgr, shirt, atol=2)
