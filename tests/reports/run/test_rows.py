"""Rows of an episode: counts, sums and columns that follow from its frames."""

from dataclasses import replace

import numpy as np
import pytest

from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import save
from reports.run.schema import CAMERAS, DETECTIONS, EPISODES, FRAMES
from reports.score.records import BUDGET_LEVELS, EpisodeFailure


def test_what_was_detected_is_there_in_its_order(run, played):
    read = load(run)
    assert list(read.detections.columns) == DETECTIONS.names
    assert list(read.cameras.columns) == CAMERAS.names
    assert len(read.detections) == 6 * 12 * 2 * 3
    mine = read.detections.query("scenario == 'cross' and seed == 2 and frame == 7")
    assert mine.view.tolist() == ["left"] * 3 + ["right"] * 3
    seen = played[5].frames[7].detections
    shape = mine[["x_px", "y_px", "a_px", "b_px", "angle_rad"]].to_numpy()
    np.testing.assert_array_equal(shape, np.vstack([view.ellipses for view in seen]))
    assert mine.area_px.tolist() == [1500.0] * 6
    camera = played[5].cameras[1]
    row = read.cameras.query("scenario == 'cross' and seed == 2 and view == 'right'").iloc[0]
    np.testing.assert_array_equal(np.reshape(row.K, (3, 3)), camera.K)
    np.testing.assert_array_equal(np.reshape(row.R_cw, (3, 3)), camera.R_cw)
    np.testing.assert_array_equal(row.t_cw, camera.t_cw)


def test_frames_without_detections_have_no_rows(episode_of, tmp_path, info):
    episode = episode_of(frames=4)
    blind = replace(
        episode, frames=tuple(replace(outcome, detections=()) for outcome in episode.frames)
    )
    assert len(load(save(tmp_path / "run", [blind], info)).detections) == 0


def test_counts_and_sums_agree_with_the_frames(run):
    read = load(run)
    episodes = read.episodes.set_index(["scenario", "seed", "target"])
    for key, rows in read.frames.groupby(["scenario", "seed", "target"]):
        episode = episodes.loc[key]
        assert episode.frames == len(rows)
        assert episode.within_50 == (rows.error_mm <= 50).sum()
        assert episode.sum_error_mm == pytest.approx(rows.error_mm.sum())
        assert episode.sum_abs_depth_mm == pytest.approx(rows.depth_mm.abs().sum())
        assert episode.n_nees == len(rows)
        assert episode.merged_frames == 0


def test_merged_frames_alone(episode_of):
    pair = np.zeros((3, 3), bool)
    pair[1, 2] = pair[2, 1] = True
    none = np.zeros((3, 3), bool)
    rows = rows_of(episode_of(merged=lambda f: (pair if f < 4 else none, none))).episodes
    assert [row["merged_frames"] for row in rows] == [0, 4, 4]
    assert rows[1]["merged_within_100"] == 4


def test_sums_of_a_worked_example(episode_of, tools):
    """Three frames: 30 mm off to the side, 40 mm too far, no estimate."""
    centres = tools.paths(3, 3.0)
    estimates = centres.copy()
    estimates[0, 1, 2] += 0.03
    estimates[1, 1] += 0.04 * np.array([-1.0, 0.0, 0.0])
    estimates[2] = np.nan
    row = rows_of(episode_of(estimates, centres_m=centres)).episodes[1]
    assert (row["target"], row["frames"], row["covered"]) == ("right_hand", 3, 2)
    assert (row["within_50"], row["within_100"]) == (2, 2)
    assert (row["n_error_mm"], row["sum_error_mm"]) == (2, pytest.approx(70.0))
    assert row["median_error_mm"] == pytest.approx(40.0)  # the silent frame counts as infinite
    # The second error points away from the cameras, the first across the view.
    assert row["sum_abs_depth_mm"] == pytest.approx(40.0, rel=0.25)
    assert row["sum_lateral_mm"] == pytest.approx(30.0 + 0.2 * 40.0, rel=0.25)


def test_a_failure_has_three_rows_and_no_frame():
    rows = rows_of(EpisodeFailure("cross", 3, "timed out", group="hand_and_hand", digest="d"))
    assert [row["target"] for row in rows.episodes] == ["head", "right_hand", "left_hand"]
    for row in rows.episodes:
        assert list(row) == EPISODES.names
        assert (row["failure"], row["frames"], row["ever_lost"]) == ("timed out", 0, False)
    assert rows.frames == {name: [] for name in FRAMES.names}
    assert rows.tracking is None


def test_a_budget_is_summed_where_every_level_has_an_error(episode_of):
    level = np.full((4, 3), 0.002)
    level[0, 1] = np.nan
    episode = replace(
        episode_of(frames=4), budget_m={name: n * level for n, name in enumerate(BUDGET_LEVELS)}
    )
    head, right, _ = rows_of(episode).episodes
    assert (head["budget_frames"], right["budget_frames"]) == (4, 3)
    assert head["sum_budget_association_mm"] == pytest.approx(4 * 4 * 2.0)
    assert right["sum_budget_surface_mm"] == pytest.approx(3 * 2.0)


def test_columns_have_one_nan_and_no_negative_zero(episode_of, tools):
    centres = tools.paths(3, 3.0)
    estimates = centres.copy()
    estimates[0] = np.nan
    columns = rows_of(episode_of(estimates, centres_m=centres)).frames
    assert {len(values) for values in columns.values()} == {3 * 3}
    assert np.isnan(columns["error_mm"][:3]).all()
    assert not any(np.signbit(columns["error_mm"][3:]))
