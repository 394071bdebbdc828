"""Colours of labels."""

import numpy as np

from reports.dataset import label_colours


def test_depth_colours_go_with_nearness():
    depth = np.array([[0.5, 1.0, 4.0, np.nan]], np.float32)
    near, middle, far, nothing = label_colours.depth_picture(depth)[0].tolist()
    assert near[2] > near[0]  # BGR: red
    assert far[0] > far[2]
    assert near != middle != far
    assert tuple(nothing) == label_colours.EMPTY
