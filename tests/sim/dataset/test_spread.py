"""The spread of a data set: against scipy's test, and a second count of the same files."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import kstest

from pjpdaf.targets import TARGETS
from sim.dataset.reader import open_dataset
from sim.dataset.spread import BINS, QUANTITIES, Quantity, Spread, _counted, spread_of

EVEN = Quantity("Evenness", "m", 2.0, 6.0)
LOG = Quantity("Speed", "m/s", 0.02, 4.0, log=True)


def spread(quantity, values):
    return Spread(quantity, tuple(_counted(quantity, np.asarray(values, float)).tolist()))


@pytest.mark.parametrize("seed", range(4))
def test_the_distance_is_that_of_scipy(seed):
    rng = np.random.default_rng(seed)
    values = [rng.uniform(2, 6, 300), rng.normal(4, 0.6, 400), rng.uniform(0, 9, 200), [2.0, 6.0]]
    for drawn in values:
        wanted = kstest(drawn, "uniform", args=(2.0, 4.0)).statistic
        assert spread(EVEN, drawn).distance == pytest.approx(wanted, abs=2 / BINS + 1e-9)
    speeds = np.exp(rng.uniform(math.log(0.02), math.log(4.0), 500))
    wanted = kstest(np.log(speeds), "uniform", args=(math.log(0.02), math.log(200.0))).statistic
    assert spread(LOG, speeds).distance == pytest.approx(wanted, abs=2 / BINS)


def test_quantiles_and_tenths():
    rng = np.random.default_rng(5)
    values = rng.uniform(2, 6, 2000)
    found = spread(EVEN, values)
    for share in (0.25, 0.5, 0.75):
        assert found.quantile(share) == pytest.approx(np.quantile(values, share), abs=0.02)
    assert sum(found.tenths) == pytest.approx(1.0)
    beyond = spread(EVEN, [1.0, 7.0, 2.1, math.nan])
    assert beyond.number == 3
    assert sum(beyond.tenths) == pytest.approx(1 / 3)
    assert (beyond.quantile(0.0), beyond.quantile(1.0)) == (2.0, 6.0)


def test_no_values_have_no_spread():
    assert math.isnan(spread(EVEN, []).distance)
    assert math.isnan(spread(EVEN, [math.nan]).quantile(0.5))


def test_a_data_set_is_counted_as_its_files_say(dataset_made):
    dataset = open_dataset(dataset_made)
    found = spread_of(dataset)
    assert found.keys() == QUANTITIES.keys()
    frames = sum(sequence.frame_count for sequence in dataset.sequences)
    assert found["distance"].number == len(TARGETS) * frames
    assert found["hand_speed"].number == 2 * frames
    assert found["truncation"].number == 2 * len(TARGETS) * frames
    distances = [
        np.linalg.norm(centre - sequence.rig.left.centre_w)
        for sequence in dataset.sequences
        for _, truth in sequence.frames()
        for centre in truth.centres_m
    ]
    assert found["distance"].quantile(0.5) == pytest.approx(np.median(distances), abs=0.02)
