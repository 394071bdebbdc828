"""`run` with and without the cache, and the verbs of `cache`."""

import pytest
from commands import assert_one_line, in_this_process

from scenarios.cache.settings import FOLDER_VARIABLE

RUN = ("run", "calm_table", "--seeds", "1", "--set", "frames=2", "--jobs", "1", "--slim")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


def footage_line(done):
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stdout.splitlines() if line.startswith("footage: ")]
    assert len(lines) <= 1
    return "".join(lines)


def test_a_run_says_where_its_pictures_come_from(tmp_path, folder):
    done = in_this_process(*RUN, "--out", tmp_path / "1")
    assert footage_line(done) == (
        f"footage: rendered and kept for the next run in {folder} (--no-cache: neither)"
    )
    done = in_this_process(*RUN, "--out", tmp_path / "2")
    assert footage_line(done) == (
        "footage: all from the cache, nothing rendered (--no-cache renders anew)"
    )
    for file in ("episodes.parquet", "events.parquet", "tracking.parquet"):
        assert (tmp_path / "1" / file).read_bytes() == (tmp_path / "2" / file).read_bytes()

    lines = in_this_process("cache", "info").stdout.splitlines()
    assert lines[0] == f"folder: {folder}"
    assert "entries: 1 episode" in lines
    assert any(line.startswith("frames: 2 stereo frames, ") for line in lines)
    assert "of this version: 1 episode; others are dropped as they age" in lines
    done = in_this_process("cache", "clear")
    assert done.stdout.startswith("removed: 1 episode, ")
    assert [path for path in folder.rglob("*") if path.is_file()] == []
    assert "entries: 0 episodes" in in_this_process("cache", "info").stdout.splitlines()


def test_without_a_cache_there_is_nothing_to_say(monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    for verb in ("info", "clear"):
        assert_one_line(in_this_process("cache", verb), 2, "the cache is off", FOLDER_VARIABLE)
