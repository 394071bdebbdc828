"""Entries of the cache: whole or not there, least recently used first to go."""

import os
import resource
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from commands import ENVIRONMENT

from scenarios.cache.folder import PART_SUFFIX
from scenarios.cache.key import FootageKey
from scenarios.cache.settings import CacheSettings
from scenarios.cache.store import FootageCache
from sim.camera.stereo_sensor import sense
from sim.recording.truths import FrameFacts
from sim.recording.writer import RecordingWriter
from sim.scene.rig import stereo_rig
from sim.script import Performance
from sim.specs import RigSpec, SceneSpec, SensorSpec
from sim.truth import Truth, ViewTruth

RENDERER = "a renderer"
SPEC = SceneSpec(rig=RigSpec(width_px=32, height_px=32), sensor=SensorSpec())


class Drawn:
    """As much of a simulation as a recording needs; nothing is rendered."""

    performance = Performance(SPEC, None, frames=1, fps=3.0, background_frames=0, seed=1)
    fps, redrawn, renderer = 3.0, 0, RENDERER
    rig = calibration = stereo_rig(SPEC.rig)


def facts():
    numbers = np.zeros((3, 3))
    view = ViewTruth(
        np.zeros((3, 2)), np.zeros(3), np.zeros(3), np.zeros((3, 4)), np.zeros((3, 3), bool)
    )
    return FrameFacts(Truth(0, 0.0, numbers, numbers, numbers, (view, view)), 0.0, (True, True))


def key(name):
    return FootageKey({"episode": name})


def write(store, name, *, noise=0, keep=True, renderer=RENDERER):
    rng = np.random.default_rng(noise)
    light = tuple(rng.integers(0, 256, (32, 32, 3), np.uint8) for _ in "lr")
    with store.pending(key(name), renderer) as pending:
        writer = RecordingWriter(pending.file)
        writer.add_frame(light, facts())
        drawn = Drawn()
        drawn.renderer = renderer
        writer.finish(drawn, key(name).record)
        pending.keep = keep
    return light


@pytest.fixture
def store(tmp_path):
    return FootageCache(CacheSettings(tmp_path, 1_000_000))


def opened(store, name, renderer=RENDERER):
    recording = store.open(key(name), renderer)
    if recording is None:
        return None
    with recording:
        return next(iter(recording.frames()))[0].pictures


def files(store):
    return [path for path in store.settings.folder.rglob("*") if path.is_file()]


def test_what_was_kept_is_there(store):
    light = write(store, "a")
    expected = sense(light, SPEC.sensor, 1, 0, 0.0)
    for mine, theirs in zip(opened(store, "a"), expected, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert opened(store, "b") is None
    assert len(files(store)) == 1


def test_another_renderer_is_a_miss_unless_there_is_none(store):
    write(store, "a")
    assert opened(store, "a", "another") is None
    assert opened(store, "a", None) is not None
    assert len(files(store)) == 1


def test_what_was_not_finished_leaves_nothing(store):
    write(store, "a", keep=False)
    with pytest.raises(RuntimeError), store.pending(key("b"), RENDERER):
        raise RuntimeError
    assert files(store) == []


def test_two_writers_of_one_entry_leave_one_whole_entry(store):
    with store.pending(key("a"), RENDERER) as slow:
        slow.file.write(b"half")
        slow.file.flush()
        light = write(store, "a")
        (path,) = (one for one in files(store) if one.suffix != PART_SUFFIX)
        whole = path.read_bytes()
        assert opened(store, "a") is not None
        slow.file.seek(0)
        slow.file.truncate()
        writer = RecordingWriter(slow.file)
        writer.add_frame(light, facts())
        writer.finish(Drawn(), key("a").record)
        slow.keep = True
    assert files(store) == [path]
    assert path.read_bytes() == whole


def test_a_damaged_entry_is_a_miss_and_written_anew(store):
    write(store, "a")
    (path,) = files(store)
    whole = path.read_bytes()
    for damaged in (b"", whole[:100], whole[:-1], whole[:50] + b"x" + whole[51:], b"x" * 10_000):
        path.write_bytes(damaged)
        assert opened(store, "a") is None
        assert not path.exists()
        write(store, "a")
        assert path.read_bytes() == whole


def test_an_entry_under_anothers_name_is_a_miss(store):
    write(store, "a")
    write(store, "b", noise=1)
    a, b = (store.find(key(name), RENDERER) for name in "ab")
    a.write_bytes(b.read_bytes())
    assert opened(store, "a") is None
    assert opened(store, "b") is not None
    write(store, "b", renderer="another")
    b.write_bytes(store.find(key("b"), "another").read_bytes())
    assert opened(store, "b") is None


def test_the_least_recently_used_goes_first(store):
    write(store, "a")
    size = sum(path.stat().st_size for path in files(store))
    small = FootageCache(replace(store.settings, limit_bytes=round(3.5 * size)))
    for number, name in enumerate("bc"):
        write(small, name, noise=number)
    for age, name in enumerate("cba"):  # a was used longest ago, then b
        os.utime(small.find(key(name), RENDERER), (1e9 - age, 1e9 - age))
    assert opened(small, "a") is not None  # and now last
    write(small, "d", noise=4)
    assert [name for name in "abcd" if small.find(key(name), RENDERER)] == ["a", "c", "d"]
    assert sum(path.stat().st_size for path in files(small)) <= 3.5 * size


def test_an_entry_that_is_read_may_go(store):
    write(store, "a")
    recording = store.open(key("a"), RENDERER)
    assert len(store.folder.clear()) == 1
    with recording:
        assert len(list(recording.frames())) == 1
    assert files(store) == []


KILLED = """
import sys, time
from pathlib import Path
from scenarios.cache.key import FootageKey
from scenarios.cache.settings import CacheSettings
from scenarios.cache.store import FootageCache

store = FootageCache(CacheSettings(Path(sys.argv[1]), 1_000_000))
with store.pending(FootageKey({"episode": "a"}), "a renderer") as pending:
    pending.file.write(b"half")
    pending.file.flush()
    print("half", flush=True)
    time.sleep(60)
"""


def test_a_writer_that_is_killed_leaves_nothing_for_long(store):
    words = [sys.executable, "-c", KILLED, str(store.settings.folder)]
    with subprocess.Popen(words, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "half\n"
        (part,) = files(store)
        assert part.suffix == PART_SUFFIX
        os.utime(part, (1, 1))
        write(store, "b")
        assert part.exists()  # its writer is alive, however old the file
        process.send_signal(signal.SIGKILL)
    assert opened(store, "a") is None
    write(store, "c")
    assert not part.exists()
    write(store, "a")
    assert opened(store, "a") is not None


def test_a_full_disk_keeps_nothing_and_harms_nothing(store):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with store.pending(key("a"), RENDERER) as pending:
            writer = RecordingWriter(pending.file)
            for _ in range(3):
                light = tuple(
                    np.random.default_rng(0).integers(0, 256, (64, 64, 3), np.uint8) for _ in "lr"
                )
                writer.add_frame(light, facts())
            writer.finish(Drawn(), key("a").record)
            pending.keep = not writer.failed
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert files(store) == []


def test_a_folder_that_cannot_be_made_is_no_cache(tmp_path):
    (tmp_path / "file").write_text("")
    store = FootageCache(CacheSettings(tmp_path / "file", 1000))
    with store.pending(key("a"), RENDERER) as pending:
        assert pending is None
    assert store.open(key("a"), RENDERER) is None
    assert store.folder.entries() == []
