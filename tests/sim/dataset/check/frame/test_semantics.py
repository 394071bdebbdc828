"""Damaged semantic classes."""

import pytest
from damaged_dataset import SEQ, edit_png, faults_of, files

from sim.dataset.labels.classes import CLASSES, class_id

PATH = f"{SEQ}/semantic_left/000003.png"


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        ("face", "hair", "other than their ids allow"),
        ("wall", "floor", "still room"),
        ("wall", "object", "other than their ids allow"),
        ("clothes", None, "known are 0 to"),
    ],
)
def test_pixels_of_another_class_are_named(copy, before, after, text):
    """Twenty pixels of one class get another."""
    own = class_id(before)

    def change(classes):
        spots = (classes == own).nonzero()
        assert len(spots[0]) >= 20
        classes[spots[0][:20], spots[1][:20]] = len(CLASSES) if after is None else class_id(after)
        return classes

    edit_png(copy / PATH, change)
    faults = faults_of(copy)
    assert files(faults) == [PATH]
    assert text in faults[0].text
