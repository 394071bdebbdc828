"""Saving a run: the same bytes in any order, whole or absent, nothing overwritten."""

import json
import os
import pickle
import random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pjpdaf.errors import BenchError
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, check_free, save, save_slim
from reports.run.schema import TABLES
from reports.score.records import OverlayPicture

FILES = tuple(f"{name}.parquet" for name in TABLES)


@settings(
    max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(shuffle=st.randoms(use_true_random=False))
def test_the_order_of_episodes_changes_no_byte(
    played, tmp_path_factory, shuffle: random.Random, info
):
    base = tmp_path_factory.mktemp("order")
    mixed = list(played)
    shuffle.shuffle(mixed)
    straight, shuffled = save(base / "a", played, info), save(base / "b", mixed, info)
    for name in FILES:
        assert (straight / name).read_bytes() == (shuffled / name).read_bytes(), name
    for film in sorted(straight.glob("films/*")):
        assert film.read_bytes() == (shuffled / "films" / film.name).read_bytes()
    assert (straight / "run.json").read_bytes() == (shuffled / "run.json").read_bytes()


def test_wall_time_is_in_no_table(played, episode_of, tmp_path, info):
    for name, seconds in (("slow", 9.0), ("quick", 0.1)):
        save(tmp_path / name, [episode_of(stage_s={"detect": seconds})], info)
    for name in FILES:
        assert (tmp_path / "slow" / name).read_bytes() == (tmp_path / "quick" / name).read_bytes()
    timing = load(tmp_path / "slow").meta["timing"]
    assert timing[0]["stage_s"]["detect"] == pytest.approx(9.0 * 30)


def test_rows_made_in_a_worker_are_as_good_as_the_episode(played, tmp_path, info):
    save(tmp_path / "a", played, info)
    sent = [pickle.loads(pickle.dumps(rows_of(one))) for one in reversed(played)]
    save(tmp_path / "b", sent, info)
    for name in FILES:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_provenance_and_checksums_are_recorded(run):
    meta = json.loads((run / "run.json").read_text(encoding="utf-8"))
    assert meta["provenance"]["argv"] == ["run", "calm_table"]
    assert meta["provenance"]["versions"]["numpy"] == np.__version__
    assert meta["scenarios"][1]["seeds"] == [0, 1, 2, 3]
    failure = {"seed": 3, "reason": "timed out", "kind": "exception"}
    assert meta["scenarios"][1]["failures"] == [failure]
    assert set(FILES) < set(meta["files"])
    assert len(meta["pictures"]) == 6
    assert meta["complete"] is True


def test_nothing_else_lies_beside_the_run(run):
    assert [p.name for p in run.parent.iterdir()] == ["night"]


def test_a_run_without_episodes_can_be_saved_and_read(tmp_path):
    read = load(save(tmp_path / "empty", [], RunInfo("empty", complete=False)))
    assert len(read.frames) == 0
    assert read.meta["complete"] is False


def test_a_fault_while_writing_leaves_nothing(played, tmp_path, monkeypatch, info):
    def broken(*_args, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("reports.run.save.write_table", broken)
    with pytest.raises(BenchError, match=r"night: cannot write the run: No space left on device\."):
        save(tmp_path / "night", played, info)
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_while_replacing_keeps_the_old_run(run, played, monkeypatch, info):
    def interrupted(*_args, **_options):
        raise KeyboardInterrupt

    before = (run / "run.json").read_bytes()
    monkeypatch.setattr("reports.run.save.write_table", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save(run, played[:1], info, force=True)
    assert (run / "run.json").read_bytes() == before
    assert [p.name for p in run.parent.iterdir()] == ["night"]


def test_an_existing_folder(run, played, tmp_path, info):
    with pytest.raises(BenchError, match="exists and is not empty; give another folder"):
        save(run, played, info)
    save(run, played[:1], info, force=True)
    assert len(load(run).meta["timing"]) == 1
    (tmp_path / "blank").mkdir()
    save(tmp_path / "blank", played[:1], info)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    with pytest.raises(BenchError, match="is not a saved run, so it is not replaced"):
        save(tmp_path / "mine", played, info, force=True)
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="is a file; give a new folder"):
        check_free(tmp_path / "file")
    with pytest.raises(BenchError, match="cannot write the run"):
        save(tmp_path / "file" / "below", played, info)


def test_an_unwritable_folder_is_one_line(played, tmp_path, monkeypatch, info):
    monkeypatch.setattr(os, "access", lambda *_args: False)  # root may write anywhere
    for folder in (tmp_path / "night", tmp_path / "some" / "where" / "night", tmp_path):
        with pytest.raises(BenchError, match=r"cannot write the run: .* is not writable\.$"):
            save(folder, played, info)


def test_the_same_episode_twice_is_refused(played, tmp_path, info):
    with pytest.raises(BenchError, match="'calm_table' seed 0 was given twice"):
        save(tmp_path / "night", [played[0], played[0]], info)


def test_a_whole_run_is_not_replaced_by_its_own_slim_copy(run):
    with pytest.raises(BenchError, match="is the whole run itself"):
        save_slim(load(run), run, force=True)
    assert not load(run).slim


def test_hostile_scenario_names_stay_inside_the_folder(episode_of, tmp_path, info):
    picture = OverlayPicture(0, b"\xff\xd8")
    episode = episode_of(frames=3, scenario="../../<b>évil", pictures=(picture,))
    folder = save(tmp_path / "night", [episode], info)
    assert {p.name for p in tmp_path.iterdir()} == {"night"}
    assert load(folder).frames.scenario.iloc[0] == "../../<b>évil"
