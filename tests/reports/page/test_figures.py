"""Charts: the numbers they draw, gaps where there is nothing, names escaped."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pandas as pd
import pytest

from reports.page.bars import stacked_bars
from reports.page.line_chart import Series, line_chart
from reports.page.path_chart import path_chart
from reports.page.speed_chart import label_speeds, speed_chart, speed_series
from reports.page.svg import path_data, round_step
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


def test_a_line_is_lifted_where_there_is_nothing():
    places = np.array([[0.0, 0.0], [1.0, 2.0], [np.nan, 0.0], [3.0, 3.0], [4.0, np.nan]])
    assert path_data(places) == "M0.0 0.0L1.0 2.0M3.0 3.0"


def test_higher_values_are_drawn_higher_and_axes_hold_them():
    line = Series("head", np.array([0.0, 1.0, 2.0]), np.array([0.0, 10.0, 20.0]))
    chart = line_chart([line], ("frame", "px"), limit=(30.0, "<limit>"))
    path = next(e for e in elements(chart, "path") if e.get("class") == "line head")
    numbers = [float(n) for n in re.findall(r"[\d.]+", path.get("d"))]
    x, y = numbers[::2], numbers[1::2]
    assert x == sorted(x)
    assert y == sorted(y, reverse=True)
    assert y[0] - y[1] == pytest.approx(y[1] - y[2], abs=0.2)
    limit = next(e for e in elements(chart, "line") if e.get("class") == "limit")
    assert float(limit.get("y1")) < y[2]
    assert "<limit>" not in chart


@pytest.mark.parametrize("silent", [False, True])
def test_paths_stay_inside_the_picture(tools, silent):
    truth = 1e3 * tools.paths(20, 3.0)
    said = np.full_like(truth, np.nan) if silent else truth + 12.0
    said[5, 1] = 1e6  # a track that ran away is cut off, the picture keeps its scale
    chart = path_chart(truth, said)
    _, _, width, height = map(float, elements(chart, "svg")[0].get("viewBox").split())
    drawn = [e for e in elements(chart, "path") if "line" in e.get("class")]
    assert len(drawn) == 2 * 3 + 3
    for path in drawn:
        numbers = [float(n) for n in re.findall(r"-?[\d.]+", path.get("d").replace("H", " "))]
        assert all(-1 <= n <= max(width, height) for n in numbers)
    lifted = sum(e.get("d").count("M") for e in drawn if "estimate right" in e.get("class"))
    assert lifted == (0 if silent else 2)


def test_stacked_bars_are_as_long_as_their_sum():
    parts = {
        "rig & lens": {"head": 5.0, "right_hand": 10.0, "left_hand": 0.0},
        "tracker": {"head": 15.0, "right_hand": 10.0, "left_hand": 0.0},
        "less": {"head": -5.0, "right_hand": 0.0, "left_hand": 0.0},
    }
    chart = stacked_bars(parts)
    bars = [e for e in elements(chart, "rect") if e.get("class").startswith("part ")]
    widths = [float(e.get("width")) for e in bars]
    assert widths[0] + widths[1] == pytest.approx(widths[3] + widths[4], abs=0.2)
    assert widths[1] == pytest.approx(3 * widths[0], abs=0.3)
    assert widths[2] == 0.0
    assert widths[6:] == [0.0] * 3
    sums = [float(e.get("x1")) for e in elements(chart, "line") if e.get("class") == "sum"]
    assert sums[1] - sums[0] == pytest.approx(widths[0], abs=0.2)
    assert "rig &amp; lens, head: 5.0 mm" in chart


@pytest.mark.parametrize(("least", "step"), [(0.3, 0.5), (1.0, 1.0), (2.1, 5.0), (70, 100)])
def test_steps_are_round(least, step):
    assert round_step(least) == pytest.approx(step)
