"""The verb `baseline accept`, on runs of points instead of pictures."""

from dataclasses import replace

import pytest
from commands import assert_one_line, in_this_process
from point_episodes import all_seen, apart, episode_of, tracker_of

from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure

REQUEST = {"targets": ["points"], "seeds": 2, "first_seed": 0, "only": [], "settings": []}


@pytest.fixture(scope="module")
def episodes():
    one = episode_of(apart, all_seen, frames=6, tracker=tracker_of())
    return [replace(one, seed=seed, digest=f"d{seed}") for seed in range(2)]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def saved(name, episodes, **info):
    return save(name, episodes, RunInfo(name.name, request=REQUEST, **info))


def test_a_first_run_is_accepted_whole_and_small(here, episodes, tmp_path):
    saved(tmp_path / "first", episodes)
    done = in_this_process("baseline", "accept", "first")
    assert done.returncode == 0, done.stderr
    assert "accepted: baselines/points (1 scenario, 2 episodes, " in done.stdout
    assert load(tmp_path / "baselines" / "points").slim
    assert in_this_process("compare", "baselines/points", "first").returncode == 0


def test_what_has_changed_since_is_said(here, episodes, tmp_path):
    saved(tmp_path / "first", episodes)
    saved(tmp_path / "again", episodes)
    saved(tmp_path / "fewer", episodes[:1])
    assert in_this_process("baseline", "accept", "first", "kept").returncode == 0
    same = in_this_process("baseline", "accept", "again", "kept")
    assert "no change: all episodes gave the same results" in same.stdout
    other = in_this_process("baseline", "accept", "fewer", "kept")
    assert "other episodes than before (1 scenario, 2 episodes): " in other.stdout
    assert load(tmp_path / "kept").digests == {("points", 0): "d0"}
    assert [path.name for path in (tmp_path / "kept").parent.glob("*kept*")] == ["kept"]


def test_a_run_that_nothing_could_be_compared_with_is_refused(here, episodes, tmp_path):
    saved(tmp_path / "part", episodes, complete=False)
    failed = EpisodeFailure("points", 0, "timed out", digest="d0")
    saved(tmp_path / "failed", [failed, episodes[1]])
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "mine.txt").write_text("mine")
    assert_one_line(in_this_process("baseline", "accept", "part"), 2, "interrupted")
    assert_one_line(in_this_process("baseline", "accept", "failed"), 5, "1 of 2 episodes")
    saved(tmp_path / "whole", episodes)
    assert_one_line(in_this_process("baseline", "accept", "whole", "kept"), 2, "it has no run.json")
    assert (tmp_path / "kept" / "mine.txt").read_text() == "mine"
