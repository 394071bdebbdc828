"""What goes into the player: the run's own numbers, small, and films within their room."""

import base64
import gzip
import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.frames import StereoFrame
from reports.page.episode_tables import episode_tables
from reports.page.packed_films import packed_films
from reports.page.player import episode_data, pack, worst_frame
from reports.pictures.stills import VIEW_WIDTH_PX, still
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.score.ranking import badness, went_wrong, worst_first
from reports.score.records import Still


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
    assert data["labels"] == [[0, "reach"], [7, "hold;near"]]
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


def test_a_still_is_undistorted_and_plain(tools):
    lens = (-0.3, 0.1, 0.0, 0.0)
    cameras = tools.cameras(lens)
    picture = np.full((480, 640, 3), 90, np.uint8)
    webp = still(StereoFrame(0, 0.0, (picture, None)), cameras)
    sheet = cv2.imdecode(np.frombuffer(webp, np.uint8), cv2.IMREAD_COLOR)
    assert sheet.shape == (240, 2 * VIEW_WIDTH_PX, 3)
    assert abs(int(sheet[120, 160, 0]) - 90) < 4
    assert sheet[:, 330:].max() > 200  # says that it is missing


@pytest.fixture(scope="module")
def filmed(episode_of, tools, tmp_path_factory):
    """A good and two bad episodes, each with all its frames; a good one with two frames."""
    centres = tools.paths(10, 3.0)
    webp = b"RIFF" + bytes(96)
    every = tuple(Still(f, webp) for f in range(10))

    def episode(estimates, film, **changes):
        return replace(episode_of(estimates, centres_m=centres, **changes), film=film)

    good = tools.noisy(centres, 0, 0.005)
    bad = good.copy()
    bad[2:, 1] += 0.4
    return load(
        save(
            tmp_path_factory.mktemp("filmed") / "run",
            [
                episode(good, every, scenario="a"),
                episode(good, every, scenario="a", seed=1),
                episode(bad, every, scenario="a", seed=2),
                episode(good, every[::5], scenario="b"),
            ],
            RunInfo("run"),
        )
    )


def test_films_are_kept_of_first_seeds_and_of_what_went_wrong(filmed):
    kept = [(film["scenario"], film["seed"], film["whole"]) for film in filmed.meta["films"]]
    assert kept == [("a", 0, True), ("a", 2, True), ("b", 0, False)]


def test_films_go_in_as_far_as_there_is_room(filmed):
    order = [("a", 2), ("a", 0), ("b", 0)]
    all_of_it = packed_films(filmed, order, (10_000, 10_000))
    assert [len(f.pictures) for f in all_of_it.values()] == [10, 10, 2]
    assert all_of_it["a", 2].sizes.startswith("0:100 1:100 ")
    assert list(packed_films(filmed, order, (1500, 10_000))) == [("a", 2), ("b", 0)]
    assert [len(f.pictures) for f in packed_films(filmed, order, (0, 150)).values()] == [1]
    assert packed_films(filmed, order, (0, 50)) == {}


def test_the_worst_come_first_and_the_good_not_at_all(episode_of, tools):
    centres = tools.paths(30, 3.0)
    episodes = {}
    for seed, shift in enumerate((0.0, 0.2, 0.12, 0.5)):
        estimates = (
            centres + np.array([0.0, 0.0, 1.0]) * shift * (np.arange(30) > 12)[:, None, None]
        )
        episodes["x", seed] = rows_of(episode_of(estimates, centres_m=centres, seed=seed)).episodes
    assert worst_first(episodes) == [("x", 3), ("x", 1), ("x", 2)]
    assert not went_wrong(episodes["x", 0])
    share, mean = badness(episodes["x", 1])
    assert share == pytest.approx(17 / 30)
    assert mean == pytest.approx(200 * 17 / 30)
