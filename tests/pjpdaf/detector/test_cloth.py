"""A shirt of the colour of skin."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.detector.cloth import cloth_mask
from pjpdaf.detector.face import Face

FOCAL_PX = 135.0
SKIN_BGR, CAMEL_BGR = (79.0, 101.0, 142.0), (99.0, 132.0, 178.0)


def scene(shirt_bgr) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Logarithms of the picture, what is in the skin range, and where the shirt is."""
    body = np.zeros((120, 160), np.uint8)
    cv2.rectangle(body, (50, 52), (110, 95), 1, -1)
    skin = np.zeros_like(body)
    cv2.ellipse(skin, (80, 38), (8, 13), 0, 0, 360, 1, -1)
    for x in (52, 108):
        cv2.ellipse(skin, (x, 92), (5, 6), 0, 0, 360, 1, -1)
    shirt = (body > 0) & (skin == 0)
    picture = np.full((120, 160, 3), 120.0)
    picture[shirt], picture[skin > 0] = shirt_bgr, SKIN_BGR
    picture += np.random.default_rng(1).normal(0, 0.8, picture.shape)
    logs = np.log(np.maximum(picture, 1.0)).astype(np.float32)
    return np.moveaxis(logs, -1, 0), (skin > 0) | shirt, shirt


def test_a_camel_shirt_is_cloth_and_hands_and_face_are_not():
    logs, in_range, shirt = scene(CAMEL_BGR)
    mask = cloth_mask(logs, in_range, Face(np.array(SKIN_BGR), 100), FOCAL_PX)
    assert mask is not None
    inside = cv2.erode(shirt.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    assert mask[inside].mean() > 0.99
    assert mask[in_range & ~shirt].mean() < 0.05


def test_a_shirt_of_the_very_colour_of_skin_is_left_alone():
    logs, in_range, _ = scene(SKIN_BGR)
    assert cloth_mask(logs, in_range, Face(np.array(SKIN_BGR), 100), FOCAL_PX) is None


def test_hands_and_face_alone_are_no_cloth():
    logs, in_range, shirt = scene(CAMEL_BGR)
    skin = in_range & ~shirt
    assert cloth_mask(logs, skin, Face(np.array(SKIN_BGR), 100), FOCAL_PX) is None


def test_a_small_shirt_is_cloth_where_its_colour_is_far_from_the_face():
    """Of a person farther away less is in the skin range than of a near one with bare arms."""
    orange, face = (66.0, 120.0, 180.0), Face(np.array(SKIN_BGR), 100)
    logs, in_range, shirt = scene(orange)
    far_px = 1.7 * FOCAL_PX
    mask = cloth_mask(logs, in_range, face, far_px)
    assert mask is not None
    assert mask[cv2.erode(shirt.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0].mean() > 0.99
    assert cloth_mask(logs, in_range, face, far_px, clear=False) is None
    logs, in_range, _ = scene(CAMEL_BGR)
    assert cloth_mask(logs, in_range, face, far_px) is None
