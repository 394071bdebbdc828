"""`run` with and without the cache, and the verbs of `cache`."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from commands import assert_one_line, in_this_process

from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.tables import tables_of
from reports.score.records import EpisodeFailure
from scenarios.cache.report import origin_line
from scenarios.cache.settings import FOLDER_VARIABLE, CacheSettings
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import play_complete


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.mark.long
def test_a_run_plays_what_is_kept_and_says_so(tmp_path, folder):
    short = ("frames=2", "background_frames=2", "detector.background_learn_min=2")
    request = PlanRequest(("calm_table",), seeds=1, settings=short)
    (job,) = plan(request)
    rendered = rows_of(play_complete(job))
    words = [word for setting in short for word in ("--set", setting)]
    words += ("--seeds", "1", "--jobs", "1", "--slim", "--out", tmp_path / "r")
    done = in_this_process("run", "calm_table", *words)
    assert done.returncode == 0, done.stderr
    line = "footage: all from the cache, nothing rendered (--no-cache renders anew)"
    assert line in done.stdout.splitlines()
    pd.testing.assert_frame_equal(
        load(tmp_path / "r").tracking, tables_of([rendered])["tracking"].to_pandas()
    )

    lines = in_this_process("cache", "info").stdout.splitlines()
    assert lines[0] == f"folder: {folder}"
    kinds = (
        "footage of 1 episode, detections of 1 episode, films of 0 episodes, scenes of 1 episode"
    )
    assert f"entries: {kinds}" in lines
    for kind in ("footage", "detections"):
        assert any(line.startswith(f"{kind}: 2 stereo frames, ") for line in lines)
    assert "damaged: 0 files" in lines
    assert "of this version: 1 episode; others are dropped as they age" in lines
    done = in_this_process("cache", "clear")
    assert done.stdout.startswith("removed: footage of 1 episode, ")
    assert [path for path in folder.rglob("*") if path.is_file()] == []
    kinds = ("footage", "detections", "films", "scenes")
    nothing = f"entries: {', '.join(f'{kind} of 0 episodes' for kind in kinds)}"
    assert nothing in in_this_process("cache", "info").stdout.splitlines()


def test_the_line_of_a_run_says_what_was_rendered():
    failure = rows_of(EpisodeFailure("cross", 0, "no step today"))
    settings = CacheSettings(Path("/c"), 1)

    def line(*replayed, settings=settings, plugged=0, detected=True):
        rows = [replace(failure, renderer="egl", replayed=one) for one in replayed]
        rows = [replace(row, detections_kept=detected) for row in rows]
        return origin_line((*rows, failure), settings, plugged)

    kept = "kept for the next run in /c (--no-cache: neither)"
    assert line(False, False) == f"footage: rendered and {kept}"
    assert line(False, True, True) == f"footage: 2 of 3 from the cache, the rest {kept}"
    assert line(True, True).startswith("footage: all from the cache, nothing rendered (")
    anew = "footage: all from the cache, nothing rendered, but detected anew ("
    assert line(True, True, detected=False).startswith(anew)
    anew = "footage: 1 episode with a plug-in's motion rendered anew, not kept (the cache cannot"
    assert line(False, plugged=1) == f"{anew} know all of its code)"
    assert line(False, True, plugged=1).endswith("its code); 1 of the others from the cache")
    assert line() == line(True, settings=None) == ""


def test_without_a_cache_there_is_nothing_to_say(monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    for verb in ("info", "clear"):
        assert_one_line(in_this_process("cache", verb), 2, "the cache is off", FOLDER_VARIABLE)
