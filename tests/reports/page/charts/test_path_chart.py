"""Paths in 3-D stay inside their picture."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from reports.page.charts.path_chart import path_chart


def elements(chart, name):
    """All elements of a chart, which must be well-formed."""
    return list(ET.fromstring(str(chart)).iter(name))


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
