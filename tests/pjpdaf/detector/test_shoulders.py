"""Where the head of a silhouette ends."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.detector.shoulders import rows_of_head

METRE_PX = 100.0


def person(shoulders: bool) -> np.ndarray:
    mask = np.zeros((120, 160), np.uint8)
    cv2.ellipse(mask, (80, 22), (8, 12), 0, 0, 360, 1, -1)
    cv2.rectangle(mask, (75, 32), (85, 37 if shoulders else 60), 1, -1)
    if shoulders:
        cv2.rectangle(mask, (60, 38), (100, 90), 1, -1)
    return mask > 0


def test_the_head_ends_where_the_silhouette_widens():
    assert rows_of_head(person(shoulders=True), 10, 45, 80.0, METRE_PX) == 28


def test_without_shoulders_it_is_as_high_as_heads_are():
    assert rows_of_head(person(shoulders=False), 10, 45, 80.0, METRE_PX) == 45


def test_hands_beside_the_brow_do_not_end_it():
    mask = person(shoulders=True)
    mask[15:25, 62:98] = True
    assert rows_of_head(mask, 10, 45, 80.0, METRE_PX) >= 13
