"""Depth of another unit, scale or frame."""

import numpy as np
import pytest
from damaged_dataset import SEQ, edit_png, faults_of, files


@pytest.mark.parametrize("frames", [(1, 2, 3, 4, 5), (3,)], ids=["all", "one"])
def test_a_wrong_unit_of_depth_is_named(copy, frames):
    paths = [copy / SEQ / "depth_right" / f"{frame:06d}.png" for frame in frames]
    for path in paths:
        edit_png(path, lambda z: (z // 10).astype(np.uint16))
    assert files(faults_of(copy)) == [path.relative_to(copy).as_posix() for path in paths]


def test_a_slightly_wrong_depth_is_named(copy):
    """By 0.2 %: 2 to 3 mm."""
    edit_png(
        copy / SEQ / "depth_left" / "000002.png", lambda z: np.rint(z * 1.002).astype(np.uint16)
    )
    assert files(faults_of(copy)) == [f"{SEQ}/depth_left/000002.png"]
