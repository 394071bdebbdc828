"""Run-length masks against pycocotools."""

import numpy as np
import pytest

from sim.dataset.check.exports.run_lengths import run_lengths
from sim.dataset.check.frame.mask_geometry import measured


def test_run_lengths_are_those_of_pycocotools():
    mask = pytest.importorskip("pycocotools.mask")
    rng = np.random.default_rng(142)
    for share in (0.0, 0.001, 0.3, 0.9, 1.0):
        picture = rng.random((37, 53)) < share
        coded = mask.encode(np.asfortranarray(picture.astype(np.uint8)))
        record = {"size": coded["size"], "counts": coded["counts"].decode()}
        area, centroid, box = run_lengths(record, (53, 37))
        count, middle, wanted = measured(picture)
        assert area == count
        np.testing.assert_allclose(centroid, middle)
        np.testing.assert_array_equal(box, wanted)
