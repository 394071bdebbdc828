"""Paths of SVG and round steps of an axis."""

import numpy as np
import pytest

from reports.page.charts.svg import path_data, round_step


def test_a_line_is_lifted_where_there_is_nothing():
    places = np.array([[0.0, 0.0], [1.0, 2.0], [np.nan, 0.0], [3.0, 3.0], [4.0, np.nan]])
    assert path_data(places) == "M0.0 0.0L1.0 2.0M3.0 3.0"


@pytest.mark.parametrize(("least", "step"), [(0.3, 0.5), (1.0, 1.0), (2.1, 5.0), (70, 100)])
def test_steps_are_round(least, step):
    assert round_step(least) == pytest.approx(step)
