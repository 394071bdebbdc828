"""A chart of lines: higher values higher, names escaped."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from reports.page.charts.line_chart import Series, line_chart


def elements(chart, name):
    """All elements of a chart, which must be well-formed."""
    return list(ET.fromstring(str(chart)).iter(name))


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
