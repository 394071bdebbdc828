"""The thesis's figures: the right episode, the right frames, numbers that are those of the run."""

import numpy as np
import pytest

from reports.page.episode_tables import episode_tables
from reports.page.thesis_figures import thesis_figures
from reports.page.thesis_measures import NOT_STATED
from reports.run.load import load
from reports.run.save import RunInfo, save

NONE = np.zeros((3, 3), bool)


def touching(a, b):
    pair = NONE.copy()
    pair[a, b] = pair[b, a] = True
    return pair


@pytest.fixture(scope="module")
def figures(episode_of, tools, tmp_path_factory):
    centres = tools.paths(60, 3.0)
    calm = centres.copy()
    calm[:, 1:, 1] += 0.004 * np.sin(np.arange(60))[:, None]  # the hands shake, the head does not
    calm[7, 1, 2] += 0.2  # above the thesis's axis once
    failing = centres.copy()
    failing[25:35] = failing[25:35][:, [0, 2, 1]]
    failing[50:, 2] += 0.4
    run = load(
        save(
            tmp_path_factory.mktemp("thesis") / "run",
            [
                episode_of(calm, centres_m=centres, scenario="calm_table", seed=2),
                episode_of(
                    centres,
                    centres_m=centres,
                    scenario="drink",
                    merged=lambda f: (touching(0, 1) if 20 <= f < 28 else NONE,) * 2,
                ),
                episode_of(
                    failing,
                    centres_m=centres,
                    scenario="fast_finish",
                    merged=lambda f: (touching(1, 2) if f in (20, 21) else NONE,) * 2,
                ),
            ],
            RunInfo("run"),
        )
    )
    played = {(take.scenario, take.seed): take for take in episode_tables(run)}
    return {f.number: f for f in thesis_figures([played, {}])}


def row_of(figure, label):
    return next(row for row in figure.rows if row.label == label)


def test_all_seven_are_there_in_order(figures):
    assert list(figures) == ["4.1", "4.2", "4.3", "4.4", "4.5", "4.6", "4.7"]
    assert figures["4.1"].source == (0, "calm_table", 2)
    assert figures["4.7"].source == (0, "fast_finish", 0)
    assert figures["4.6"].source == (0, "fast_finish", 0)  # no merge_and_hold here


def test_a_run_without_the_scenario_says_nothing(figures):
    for figure in figures.values():
        assert all(row.ours[1] == "-" for row in figure.rows)
    empty = thesis_figures([{}])
    assert all(f.source is None and f.chart is None and f.frames == () for f in empty)
    assert empty[0].scenarios == ("calm_table",)


def test_frames_are_those_of_the_thesis_counted_from_one(figures):
    assert figures["4.1"].frames == (0, 14, 49)  # 75 and on are not in sixty frames
    assert figures["4.5"].frames == (0, 20, 22, 26, 29, 30, 31, 35, 39, 48)
    assert figures["4.6"].frames == (20,)
    assert row_of(figures["4.5"], "hand on the head").ours[0] == "21-28"
    assert row_of(figures["4.6"], "both hands are one area").ours[0] == "frames 21-22"


def test_errors_beyond_the_axis_are_counted(figures):
    figure = figures["4.3"]
    assert row_of(figure, "above 20 px").ours[0] == "1 of 180 target-frames"
    assert row_of(figure, "head steadier than the hands").ours[0].startswith("yes")
    assert row_of(figure, "median Err_acc, head / right / left").thesis == NOT_STATED
    assert "the thesis&#39;s axis ends here" in figure.chart


def test_extents_are_in_the_left_cameras_frame(figures):
    # The person sits about 1 m to 1.3 m from the cameras at x = 1.3 m.
    words = row_of(figures["4.2"], "depth (z)").ours[0]
    low, high = (float(n) for n in words.partition(" mm")[0].split(" to "))
    assert 850 < low < 1000
    assert 1200 < high < 1300


def test_failures_are_told_by_frame(figures):
    figure = figures["4.7"]
    assert row_of(figure, "hands confused").ours[0] == "26-35"
    assert row_of(figure, "lost at the end").ours[0] == "left hand"
    assert row_of(figure, "hands together").ours[0] == "21-22; 100 % within 100 mm meanwhile"
    assert {0, 20, 25, 59} <= set(figure.frames)
    assert len(figure.frames) <= 10
