"""Merged masks against `sim.labels`."""

import numpy as np

from sim.dataset.check.frame.mask_geometry import measured, merged
from sim.labels import merged as drawn_merged


def test_masks_within_the_touch_are_merged_as_the_simulation_has_it():
    rng = np.random.default_rng(141)
    for _ in range(200):
        seg = np.zeros((40, 50), np.uint8)
        for target in (1, 2, 3):
            x, y = rng.integers(0, 40), rng.integers(0, 30)
            seg[y : y + rng.integers(1, 10), x : x + rng.integers(1, 10)] = target
        boxes = np.array([measured(seg == target)[2] for target in (1, 2, 3)])
        wanted = drawn_merged(seg.astype(np.int8) - 1, boxes)
        np.testing.assert_array_equal(merged(seg, boxes), wanted)
