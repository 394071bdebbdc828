"""The speed curve: the runs' own shares, nothing without strokes."""

import xml.etree.ElementTree as ET

import numpy as np
import pandas as pd
import pytest

from reports.page.charts.speed_chart import label_speeds, speed_chart, speed_series
from reports.run.load import load
from reports.run.save import RunInfo, save


@pytest.fixture
def run(episode_of, tools, tmp_path):
    centres = tools.paths(12, 3.0)
    estimates = centres.copy()
    estimates[:, 1, 0] += 0.08  # between the bounds of 50 and 100 mm
    estimates[0] = np.nan
    estimates[6:, 2] += [0.3, 0, 0]
    episode = episode_of(
        estimates,
        centres_m=centres,
        labels=lambda f: ("reach", f"speed:{0.5 if f < 6 else 1}"),
    )
    return load(save(tmp_path / "run", [episode], RunInfo("run")))


def elements(chart, name):
    """All elements of a chart, which must be well-formed."""
    return list(ET.fromstring(str(chart)).iter(name))


def test_speed_curve(run, episode_of, tmp_path):
    right, left = speed_series(run.frames)
    assert right.x.tolist() == [0.5, 1.0]
    assert right.y.tolist() == [pytest.approx(100 * 5 / 6), 100.0]  # frame 0 was silent
    assert left.y[1] == 0.0
    chart = speed_chart(run.frames)
    assert "right hand, 0.5 m/s: 83.3 % of 6 frames" in chart
    assert len([e for e in elements(chart, "rect") if "mark" in e.get("class")]) >= 4
    plain = load(save(tmp_path / "plain", [episode_of()], RunInfo("plain")))
    assert speed_chart(plain.frames) is None


def test_labels_that_are_no_speed():
    found = label_speeds(pd.Series(["speed:0.5", "grasp;speed:2", "speed:fast", "speed:-1", ""]))
    np.testing.assert_array_equal(found, [0.5, 2, np.nan, np.nan, np.nan])
