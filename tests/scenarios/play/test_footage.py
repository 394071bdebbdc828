"""Footage is rendered once, and what is replayed is what was rendered."""

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import ENVIRONMENT

from pjpdaf.errors import PlugInFault
from reports.run.rows import rows_of
from scenarios.cache.renderer import MEMO
from scenarios.cache.settings import FOLDER_VARIABLE, SIZE_VARIABLE
from scenarios.play.footage import is_cached, open_footage
from scenarios.play.job import Job, System
from scenarios.play.play import play_complete
from scenarios.spec.names import load_scenario
from sim import gl
from sim.sequence import Simulation

JOB = Job(
    load_scenario("cross"),
    5,
    {"frames": 3, "background_frames": 10, "dropped": 0.1},
    System(),
    keep_pictures=True,
    keep_film=True,
    size_px=(160, 120),
)


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A cache that has the footage of JOB, and the episode that was rendered for it."""
    folder = tmp_path_factory.mktemp("filled") / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(folder))
        assert not is_cached(JOB)
        episode = play_complete(JOB)
    assert not episode.replayed
    return folder, episode


@pytest.fixture
def first(filled):
    return filled[1]


@pytest.fixture
def empty(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def folder(filled, empty):
    """A copy of the filled cache."""
    return Path(shutil.copytree(filled[0], empty))


def entries(folder):
    return sorted(folder.rglob("*.rec"))


def without_times(episode):
    return repr(replace(rows_of(episode), stage_s={}, replayed=False, detections_kept=False))


def test_an_episode_is_rendered_once_and_replayed_bit_for_bit(folder, first, monkeypatch):
    assert len(entries(folder)) == 1
    assert is_cached(JOB)

    def refused(*arguments):
        raise AssertionError("nothing is rendered, and OpenGL is not asked")

    with monkeypatch.context() as patch:
        patch.setattr(Simulation, "__init__", refused)
        patch.setattr(gl, "describe", refused)
        again = play_complete(JOB)
        other_tracker = play_complete(replace(JOB, system=System("thesis", "thesis")))
    assert again.replayed
    assert other_tracker.replayed
    assert again.renderer == first.renderer == gl.describe()
    assert without_times(again) == without_times(first)
    assert not any(
        is_cached(replace(JOB, **other))
        for other in ({"seed": 6}, {"overrides": {"frames": 2}}, {"use_cache": False})
    )
    uncached = play_complete(replace(JOB, use_cache=False))
    assert not uncached.replayed
    assert without_times(uncached) == without_times(first)


def test_a_damaged_entry_is_rendered_again(folder, first):
    (path,) = entries(folder)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    again = play_complete(JOB)
    assert not again.replayed
    assert without_times(again) == without_times(first)
    assert path.read_bytes() == whole


def test_what_is_not_played_to_its_end_is_not_kept(empty):
    with open_footage(JOB) as footage:
        next(iter(footage.frames()))
    assert entries(empty) == []


def played_by_a_faulty_system(footage):
    pictures = list(footage.frames())
    raise PlugInFault(pictures)


def test_pictures_of_a_system_that_fails_after_all_of_them_are_good(empty):
    with pytest.raises(PlugInFault) as fault, open_footage(JOB) as footage:
        played_by_a_faulty_system(footage)
    (pictures,) = fault.value.args
    assert is_cached(JOB)
    with open_footage(JOB) as footage:
        for (one, _), (other, _) in zip(footage.frames(), pictures, strict=True):
            for a, b in zip(one.pictures, other.pictures, strict=True):
                np.testing.assert_array_equal(a, b)


def watch(job):
    with open_footage(job) as footage:
        return len(list(footage.frames()))


def test_a_cache_that_is_too_small_or_cannot_be_written_is_none(empty, monkeypatch, tmp_path):
    monkeypatch.setenv(SIZE_VARIABLE, "0.000001")
    assert watch(JOB) == 3
    assert entries(empty) == []
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "file" / "cache"))
    assert watch(JOB) == 3


@pytest.mark.long
def test_no_opengl_is_needed(folder, first):
    (folder / MEMO).unlink()
    code = (
        "import sys; from scenarios.play.job import Job, System; "
        "from scenarios.play.play import play; from scenarios.spec.names import load_scenario; "
        f"job = Job(load_scenario('cross'), 5, {JOB.overrides!r}, System(), size_px=(160, 120)); "
        "episode = play(job); print(episode.replayed, 'mujoco' in sys.modules, episode.renderer)"
    )
    environment = {**ENVIRONMENT, FOLDER_VARIABLE: str(folder), "MUJOCO_GL": "disabled"}
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert done.stdout == f"True False {first.renderer}\n", done.stderr
