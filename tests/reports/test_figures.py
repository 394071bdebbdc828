"""Figures as plain values: JSON without NaN, gaps where there is no estimate."""

import json

import numpy as np
import pandas as pd
import pytest

from reports.figures import error_figure, label_speeds, merged_spans, path_figure, speed_figure
from reports.results import RunInfo, load, save


@pytest.fixture
def run(episode_of, tools, tmp_path):
    pair = np.zeros((3, 3), bool)
    pair[1, 2] = pair[2, 1] = True
    none = np.zeros((3, 3), bool)
    centres = tools.paths(12, 3.0)
    estimates = centres.copy()
    estimates[:, 1, 0] += 0.08  # between the bounds of 50 and 100 mm
    estimates[0] = np.nan
    estimates[6:, 2] += [0.3, 0, 0]
    return load(
        save(
            tmp_path / "run",
            [
                episode_of(
                    estimates,
                    centres_m=centres,
                    merged=lambda f: (none, pair if f in (3, 4, 8) else none),
                    labels=lambda f: ("reach", f"speed:{0.5 if f < 6 else 1}"),
                )
            ],
            RunInfo("run"),
        )
    )


def test_error_figure(run):
    figure = error_figure(run.frames, run.events)
    json.dumps(figure, allow_nan=False)
    first = figure["data"][0]
    assert first["name"] == "head"
    assert first["x"] == list(range(12))
    assert first["y"][0] is None
    assert first["y"][1] == 0.0
    assert len(figure["layout"]["shapes"]) == 2
    names = [trace["name"] for trace in figure["data"]]
    assert "left hand lost" in names
    dashes = {trace["line"]["dash"] for trace in figure["data"][:3]}
    assert len(dashes) == 3  # colour is not the only sign


def test_path_figure(run):
    figure = path_figure(run.frames)
    json.dumps(figure, allow_nan=False)
    truth, estimate = figure["data"][:2]
    assert truth["line"]["width"] < estimate["line"]["width"]
    assert estimate["x"][0] is None
    assert truth["x"][0] is not None


def test_merged_spans(run):
    assert merged_spans(run.frames) == [(3, 4), (8, 8)]


def test_speed_figure(run, episode_of, tmp_path):
    figure = speed_figure(run.frames)
    right, left = figure["data"]
    assert right["x"] == [0.5, 1.0]
    assert right["y"] == [pytest.approx(100 * 5 / 6, abs=0.01), 100.0]  # frame 0 was silent
    assert left["y"][1] == 0.0
    plain = load(save(tmp_path / "plain", [episode_of()], RunInfo("plain")))
    assert speed_figure(plain.frames) is None


def test_labels_that_are_no_speed():
    found = label_speeds(pd.Series(["speed:0.5", "grasp;speed:2", "speed:fast", "speed:-1", ""]))
    np.testing.assert_array_equal(found, [0.5, 2, np.nan, np.nan, np.nan])
