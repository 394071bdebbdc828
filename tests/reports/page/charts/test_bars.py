"""Bars: as long as their numbers, names escaped."""

import xml.etree.ElementTree as ET

import pytest

from reports.dataset.histograms import bin_names
from reports.page.charts.bars import counted_bars, stacked_bars


def elements(chart, name):
    """All elements of a chart, which must be well-formed."""
    return list(ET.fromstring(str(chart)).iter(name))


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


def test_bars_are_valid_and_escaped():
    root = ET.fromstring(counted_bars("<&\"'", bin_names((-1.5, 0, 2)), (1, 3)))
    bars = [e for e in root.iter("{http://www.w3.org/2000/svg}rect") if e.get("class") == "bar"]
    long = [float(bar.get("width")) for bar in bars]
    assert long[0] == pytest.approx(long[1] / 3, abs=0.1)
    words = [e.text for e in root.iter("{http://www.w3.org/2000/svg}text")]
    assert words == ["<&\"'", "−1.5 – 0", "1 (25.0 %)", "0 – 2", "3 (75.0 %)"]
    assert "NaN" not in counted_bars("empty", ("a",), (0,))
