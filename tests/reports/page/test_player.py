"""What goes into the player: the run's own numbers, small, and films within their room."""

import base64
import gzip
import json

import numpy as np
import pytest

from pjpdaf.camera import project
from reports.page.episode_tables import episode_tables
from reports.page.player import episode_data, pack, worst_frame
from reports.run.load import load
from reports.run.save import RunInfo, save


def undo(deltas, scale):
    """The series that a list of differences stands for."""
    out, last = [], 0
    for delta in deltas:
        last = last if delta is None else last + delta
        out.append(np.nan if delta is None else last * scale)
    return np.array(out)


@pytest.fixture
def take(episode_of, tools, tmp_path):
    centres = tools.paths(20, 3.0)
    estimates = tools.noisy(centres, 3)
    estimates[:2] = np.nan
    estimates[9:, 1:] = estimates[9:, :0:-1].copy()
    pair = np.zeros((3, 3), bool)
    pair[1, 2] = pair[2, 1] = True
    episode = episode_of(
        estimates,
        centres_m=centres,
        merged=lambda f: (pair if f == 4 else np.zeros((3, 3), bool),) * 2,
        labels=lambda f: ("reach",) if f < 7 else ("hold", "near"),
        exchange=np.where(np.arange(20) < 2, np.nan, np.arange(20) / 40),
    )
    return episode, next(episode_tables(load(save(tmp_path / "run", [episode], RunInfo("run")))))


def test_the_page_has_the_runs_own_numbers(take):
    episode, mine = take
    data = json.loads(gzip.decompress(base64.b64decode(pack(mine))))
    assert data == episode_data(mine)
    truth = np.stack([undo(column, 1e-4) for column in data["truth"]], axis=1).reshape(-1, 3, 3)
    said = np.stack([undo(column, 1e-4) for column in data["estimates"]], axis=1).reshape(-1, 3, 3)
    wanted = np.stack([o.truth.centres_m for o in episode.frames])
    np.testing.assert_allclose(truth, wanted, atol=0.51e-4)
    np.testing.assert_allclose(
        said, np.stack([o.estimates.positions_m for o in episode.frames]), atol=0.51e-4
    )
    error = 1e3 * np.linalg.norm(said - truth, axis=2)
    np.testing.assert_allclose(np.stack([undo(c, 0.1) for c in data["mm"]], 1), error, atol=0.3)
    assert data["merged"] == ["0" * 20, "00001" + "0" * 15, "00001" + "0" * 15]
    assert data["status"][0] == "00" + "1" * 18
    assert data["labels"] == [[0, "reach"], [7, "hold · near"]]
    stated = [o.estimates.exchange_probability for o in episode.frames]
    np.testing.assert_allclose(undo(data["exchange"], 1e-3), stated, atol=0.51e-3)
    assert {event["kind"] for event in data["events"]} >= {"swap"}


def test_cameras_and_detections_fit_the_pictures(take):
    episode, mine = take
    data = episode_data(mine)
    point = episode.frames[3].truth.centres_m[1]
    for v, camera in enumerate(episode.cameras):
        q = np.array(data["cameras"][v]["P"]).reshape(3, 4) @ np.append(point, 1.0)
        np.testing.assert_allclose(q[:2] / q[2], project(camera, point), atol=1e-3)
        seen = data["detections"][v]
        assert seen["n"] == "3" * 20
        ellipses = np.array(seen["v"], dtype=float).T.reshape(20, 3, 5) / [10, 10, 10, 10, 100]
        truth = episode.frames[3].detections[v].ellipses
        np.testing.assert_allclose(ellipses[3], truth, atol=0.051)


def test_a_frame_is_small(episode_of, tools, tmp_path):
    centres = tools.paths(150, 3.0)
    episode = episode_of(tools.noisy(centres, 1), centres_m=centres)
    mine = next(episode_tables(load(save(tmp_path / "run", [episode], RunInfo("run")))))
    assert len(pack(mine)) / 150 < 160  # bytes


def test_the_worst_frame_is_where_it_fails(take):
    _, mine = take
    worst = worst_frame(mine)
    assert 9 <= worst < 20
    assert worst_frame(mine, (0, 4)) == worst  # nothing went wrong in these
    assert worst_frame(mine, (0, 14)) == 14  # nearly as bad, and there is something to see
