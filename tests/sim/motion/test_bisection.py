"""Bisection: the place where a condition begins to hold."""

from __future__ import annotations

import pytest

from sim.motion.bisection import bisect


@pytest.mark.parametrize("threshold", [0.1, 0.5, 0.7321, 2.9])
def test_the_interval_brackets_the_threshold_and_halves_every_round(threshold):
    low, high = bisect(-1.0, 3.0, 20, lambda x: x >= threshold)
    assert low < threshold <= high
    assert high - low == pytest.approx(4.0 / 2**20)


def test_a_condition_that_never_or_always_holds_keeps_its_end():
    assert bisect(0.0, 1.0, 30, lambda x: False)[1] == 1.0
    assert bisect(0.0, 1.0, 30, lambda x: True)[0] == 0.0
