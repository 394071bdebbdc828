"""The summary: shares of all frames, episodes that gave nothing counted."""

import math

import numpy as np
import pytest

from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure
from reports.summary.tables import summarise
from reports.summary.text import number, percent


@pytest.fixture
def summary(episode_of, tools, tmp_path):
    centres = tools.paths(20, 3.0)
    off = centres + np.array([0, 0, 0.02])
    silent = off.copy()
    silent[:5] = np.nan
    swapped = off[:, [0, 2, 1]]
    episodes = [
        episode_of(off, centres_m=centres, scenario="calm", seed=0),
        episode_of(silent, centres_m=centres, scenario="calm", seed=1),
        episode_of(swapped, centres_m=centres, scenario="cross", seed=0),
        EpisodeFailure("cross", 1, "timed out"),
    ]
    return summarise(load(save(tmp_path / "run", episodes, RunInfo("night"))))


def row(summary, scenario, target):
    rows = [*summary.rows, *summary.total]
    return next(r for r in rows if (r.scenario, r.target) == (scenario, target))


def test_silent_frames_count_against_the_share(summary):
    head = row(summary, "calm", "head")
    assert (head.frames, head.covered) == (40, 35)
    assert head.within_100 == pytest.approx(35 / 40)
    assert head.within_50 == pytest.approx(35 / 40)
    assert head.median_mm == pytest.approx(20)
    assert head.p90_mm == math.inf
    assert (head.swapped, head.lost, head.episodes) == (None, 0, 2)


def test_swaps_losses_and_failures(summary):
    right = row(summary, "cross", "right_hand")
    assert (right.swapped, right.lost, right.episodes, right.failed) == (1, 1, 2, 1)
    everything = row(summary, "all", "all")
    assert (everything.swapped, everything.lost, everything.episodes) == (1, 1, 4)
    assert everything.frames == 180
    assert summary.failures == (("cross", 1, "timed out"),)


def test_the_hands_have_a_median_of_their_own(summary):
    assert summary.hands_mm["calm"] == pytest.approx(20)
    assert summary.hands_mm["cross"] > 100
    assert summary.hands_mm["all"] == pytest.approx(20)


def test_times(summary):
    assert summary.times[0].render_ms == pytest.approx(30)
    assert summary.total_times.track_ms == pytest.approx(4)


def test_a_run_without_episodes_has_a_summary(tmp_path):
    summary = summarise(load(save(tmp_path / "run", [], RunInfo("none"))))
    assert summary.overall.frames == 0


def test_numbers():
    assert [percent(s) for s in (1.0, 0.9999, 0.0, 0.0001, 0.89, math.nan)] == [
        "100 %",
        "> 99.9 %",
        "0 %",
        "< 0.1 %",
        "89.0 %",
        "-",
    ]
    assert [number(v) for v in (20.04, 99.96, 123.4, math.inf, math.nan)] == [
        "20.0",
        "100",
        "123",
        "∞",
        "-",
    ]
