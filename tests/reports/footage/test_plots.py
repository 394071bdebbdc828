"""Charts of tracks: gaps where there is no estimate, lanes as long as a status."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from reports.footage.plots import MARKERS_UP_TO, paths_chart, status_spans, time_chart

WAITING, TRACKED, LOST = (("waiting",) * 3, ("tracked",) * 3, ("lost", "tracked", "tracked"))


def elements(chart, kind):
    """The elements of a chart, which must be well-formed, that are of this class."""
    return [e for e in ET.fromstring(str(chart)).iter() if kind in e.get("class", "").split()]


def test_a_line_has_a_gap_without_an_estimate_and_a_mark_for_each(record_of):
    samples = record_of([TRACKED, TRACKED, WAITING, LOST, TRACKED]).samples
    chart = time_chart(samples, ())
    heads = elements(chart, "mark")
    titles = [e[0].text for e in heads if "head" in e.get("class").split() and len(e)]
    assert titles[:4] == [f"head, {t:.2f} s: 0.000" for t in (0, 0.5, 1.5, 2)]
    hollow = [e[0].text for e in elements(chart, "hollow")]
    assert hollow == [f"head, 1.50 s: {v}" for v in ("0.000", "-0.300", "1.200")]
    (x, *_) = [e for e in elements(chart, "line") if e.get("class") == "line head"]
    assert x.get("d").count("M") == 2


def test_long_footage_has_lines_alone(record_of):
    samples = record_of([TRACKED] * (MARKERS_UP_TO + 1)).samples
    assert not any(len(e) for e in elements(time_chart(samples, ()), "mark"))


def test_y_of_a_camera_points_down(record_of):
    chart = time_chart(record_of([TRACKED] * 2).samples, ())
    ends = {e[0].text: float(e.get("cy", 0)) for e in elements(chart, "mark") if len(e)}
    hands = {e[0].text: float(e.get("y", 0)) for e in elements(chart, "mark") if len(e)}
    assert ends["head, 0.00 s: -0.300"] < hands["right hand, 0.00 s: 0.100"]


def test_lanes_last_from_sample_to_sample_and_missing_pictures_are_shaded(record_of):
    record = record_of([TRACKED, TRACKED, LOST, LOST], missing=(1,))
    spans = [(s.target, s.kind, s.start, s.end) for s in status_spans(record.samples)]
    assert spans == [
        ("head", "tracked", 0.0, 1.0),
        ("head", "lost", 1.0, 2.0),
        ("right_hand", "tracked", 0.0, 2.0),
        ("left_hand", "tracked", 0.0, 2.0),
    ]
    chart = time_chart(record.samples, record.missing_frames)
    whole = next(e for e in elements(chart, "lane") if "left_hand" in e.get("class"))
    (shade,) = elements(chart, "shade")
    scale = float(whole.get("width")) / 2.0
    assert float(shade.get("width")) == pytest.approx(0.5 * scale, abs=0.1)
    start = float(shade.get("x")) - float(whole.get("x"))
    assert start == pytest.approx(0.25 * scale, abs=0.1)


def test_paths_are_seen_from_the_cameras_side(record_of):
    """Right in the picture is right, down is down; the numbers are those of the camera's frame."""
    chart = paths_chart(record_of([TRACKED] * 3).samples)
    words = [e.text for e in ET.fromstring(str(chart)).iter() if e.tag.endswith("text")]
    assert {"x, right [mm]", "y, down [mm]", "z, depth [mm]"} <= set(words)
    assert {"1200", "-200", "200", "-400"} <= set(words)
    ends = [e for e in elements(chart, "mark") if len(e)]
    head = (float(ends[0].get("cx")), float(ends[0].get("cy")))
    right, left = (np.array([float(e.get("x")), float(e.get("y"))]) for e in ends[1:])
    assert right[0] < head[0] < left[0]
    assert head[1] < min(right[1], left[1])


def test_a_track_that_never_is_there_has_an_empty_box(record_of):
    chart = paths_chart(record_of([WAITING] * 3).samples)
    assert not re.search("nan", str(chart), re.I)
    assert elements(chart, "grid")
