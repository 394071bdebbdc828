"""Damaged normals."""

import numpy as np
import pytest
from damaged_dataset import SEQ, edit_png, faults_of, files

PATH = f"{SEQ}/normals_right/000004.png"


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda n: n[..., ::-1], "degrees off"),  # red, green, blue in the other order
        (lambda n: 255 - n, "degrees off"),  # turned round
        (lambda n: np.dstack([n[..., 0], 255 - n[..., 1], n[..., 2]]), "degrees off"),  # y up
        (lambda n: np.roll(n, 40, axis=1), "degrees off"),
        (lambda n: n * (np.arange(n.shape[1]) > 9)[None, :, None], "has or lacks a normal"),
    ],
    ids=["order", "turned", "y up", "shifted", "lost"],
)
def test_other_normals_are_named(copy, change, text):
    edit_png(copy / PATH, lambda picture: np.ascontiguousarray(change(picture), np.uint8))
    faults = faults_of(copy)
    assert files(faults) == [PATH]
    assert text in faults[0].text
