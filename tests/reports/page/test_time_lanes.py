"""Lanes of the time line: what failed, merged and hid, in words."""

from dataclasses import replace

import numpy as np

from reports.page.episode_tables import episode_tables
from reports.page.time_lanes import TimeLane, spans_of, time_lanes
from reports.run.load import load
from reports.run.save import RunInfo, save

HANDS = "merge:right_hand+left_hand"


def test_spans_are_runs_of_frames():
    assert spans_of(np.array([1, 1, 0, 0, 1, 0, 1], dtype=bool)) == ((0, 1), (4, 4), (6, 6))
    assert spans_of(np.zeros(3, dtype=bool)) == ()
    assert spans_of(np.ones(3, dtype=bool)) == ((0, 2),)


def test_failures_merges_by_view_and_hidden_targets_have_lanes(episode_of, tools, tmp_path):
    centres = tools.paths(20, 3.0)
    estimates = centres.copy()
    estimates[12:] = estimates[12:][:, [0, 2, 1]]
    episode = episode_of(
        estimates,
        centres_m=centres,
        labels=lambda f: (
            "reach",
            *([f"{HANDS}:left_view"] if 3 <= f < 6 or f == 8 else []),
            *(["merge:head+left_hand:right_view"] if f == 10 else []),
        ),
    )
    covered = []
    for n, outcome in enumerate(episode.frames):
        left, right = outcome.truth.views
        if n in (15, 16):
            right = replace(right, visible_px=np.array([4000, 1500, 800]))  # 0.46 of the left hand
        if n == 19:
            left = replace(left, visible_px=np.array([4000, 0, 1400]))
        covered.append(replace(outcome, truth=replace(outcome.truth, views=(left, right))))
    episode = replace(episode, frames=tuple(covered))
    mine = next(episode_tables(load(save(tmp_path / "run", [episode], RunInfo("run")))))
    assert time_lanes(mine) == (
        TimeLane("swap", "left and right exchanged", -1, ((12, 19),)),
        TimeLane("lost", "right hand lost", 1, ((12, 19),)),
        TimeLane("lost", "left hand lost", 2, ((12, 19),)),
        TimeLane("merged", "head and left hand merged, right view", -1, ((10, 10),)),
        TimeLane("merged", "hands merged, left view", -1, ((3, 5), (8, 8))),
        TimeLane("hidden", "right hand hidden, left view", 1, ((19, 19),)),
        TimeLane("hidden", "left hand hidden, right view", 2, ((15, 16),)),
    )
