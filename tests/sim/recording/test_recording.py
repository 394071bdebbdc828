"""A recording gives what the simulation gave, bit for bit, or says that it is damaged."""

import hashlib
import json
import struct
from dataclasses import fields, replace

import numpy as np
import pytest

from pjpdaf.errors import FileError
from sim.person.rest import rest_pose
from sim.recording.recorder import RecordedSimulation
from sim.recording.recording import MAGIC, TAIL, Recording
from sim.script import Performance
from sim.sequence import Simulation
from sim.specs import (
    CalibrationError,
    ClockSpec,
    ObjectSpec,
    RigSpec,
    RoomSpec,
    SceneSpec,
    SensorSpec,
)

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
SCENE = SceneSpec(
    rig=RigSpec(tilt_rad=0.28, focal_px=81.0, width_px=96, height_px=72),
    room=RoomSpec(objects=(CAN,)),
    sensor=SensorSpec(
        exposure_time_s=0.01,
        skew_s=0.02,
        white_balance_rgb=(1.1, 1.0, 0.9),
        flicker=0.03,
        shot_noise_sd=2.0,
        jpeg_quality=90,
    ),
    clock=ClockSpec(jitter_s=0.02, stamps="nominal", dropped=0.3),
    calibration_error=CalibrationError(baseline=0.02),
)
KEY = {"episode": "one", "libraries": {"numpy": "2"}}


class Lifting:
    """The left hand rises at 0.3 m/s."""

    def pose(self, t_s):
        palms = ((0.34, -0.20, 0.77), (0.34, 0.20, 0.77 + 0.3 * t_s))
        return rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)

    def events(self, t_s):
        return ("lift", "ünter") if t_s > 0.5 else ()


PERFORMANCE = Performance(
    SCENE, Lifting(), frames=4, fps=3.0, background_frames=2, seed=7, redrawn=3
)


def record(path, performance, *, background=True):
    """What the simulation gave while it was recorded: background, frames with truth."""
    with Simulation(performance) as simulation, path.open("wb") as file:
        recorded = RecordedSimulation(simulation, file, KEY)
        empty = recorded.background() if background else []
        frames = list(recorded.frames())
        assert recorded.complete
    return empty, frames


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "a.rec"
    return path, *record(path, PERFORMANCE)


def assert_same_frames(ones, others):
    for one, other in zip(ones, others, strict=True):
        assert (one.index, one.time_s) == (other.index, other.time_s)
        for a, b in zip(one.pictures, other.pictures, strict=True):
            assert (a is None) == (b is None)
            assert a is None or np.array_equal(a, b)


def assert_same_values(one, other):
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if field.name == "views":
            for x, y in zip(a, b, strict=True):
                assert_same_values(x, y)
        elif isinstance(a, np.ndarray):
            assert a.dtype == b.dtype
            assert a.tobytes() == b.tobytes(), field.name
        else:
            assert a == b, field.name


def test_a_recording_gives_what_the_simulation_gave(made):
    path, empty, frames = made
    with Recording(path) as recording:
        assert_same_frames(recording.background(), empty)
        replayed = list(recording.frames())
        again = list(recording.frames())
    assert_same_frames([f for f, _ in replayed], [f for f, _ in frames])
    assert_same_frames([f for f, _ in again], [f for f, _ in frames])
    for (_, mine), (_, theirs) in zip(replayed, frames, strict=True):
        assert_same_values(mine, theirs)
    assert any(picture is None for f, _ in frames for picture in f.pictures)
    assert replayed[-1][1].events[:2] == ("lift", "ünter")


def test_it_has_the_facts_of_the_sequence(made):
    path, _, _ = made
    with Simulation(PERFORMANCE) as simulation, Recording(path) as recording:
        assert (recording.fps, recording.frame_count, recording.redrawn) == (3.0, 4, 3)
        assert recording.renderer == simulation.renderer
        for name in ("rig", "calibration"):
            mine, theirs = getattr(recording, name), getattr(simulation, name)
            for a, b in zip(mine.cameras, theirs.cameras, strict=True):
                assert_same_values(a, b)
        assert recording.footer.key == KEY


@pytest.mark.parametrize("background_frames", [0, 2])
def test_the_background_may_be_asked_for_late_or_never(tmp_path, made, background_frames):
    path = tmp_path / "b.rec"
    performance = replace(PERFORMANCE, frames=2, background_frames=background_frames)
    _, frames = record(path, performance, background=False)
    with Recording(path) as recording:
        assert_same_frames([f for f, _ in recording.frames()], [f for f, _ in frames])
        assert_same_frames(recording.background(), made[1][:background_frames])


def test_an_unfinished_recording_is_damaged(tmp_path):
    path = tmp_path / "a.rec"
    with Simulation(PERFORMANCE) as simulation, path.open("wb") as file:
        recorded = RecordedSimulation(simulation, file, KEY)
        next(iter(recorded.frames()))
        assert not recorded.complete
    with pytest.raises(FileError, match="is a damaged recording"):
        Recording(path)


def test_every_cut_and_every_changed_byte_shows(made, tmp_path):
    data = made[0].read_bytes()
    path = tmp_path / "a.rec"
    steps = [*range(0, len(data), max(1, len(data) // 60)), len(data) - 1, len(data) - 40]
    for at in steps:
        for damaged in (data[:at], data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]):
            path.write_bytes(damaged)
            with pytest.raises(FileError, match=f"^{path}: is a damaged recording"):
                Recording(path)
    path.write_bytes(data)
    Recording(path).close()


def forged(data, **changed):
    """A recording with another footer, and the right checksum."""
    start, length, _ = TAIL.unpack(data[-TAIL.size :])
    footer = json.loads(data[start : start + length])
    text = json.dumps({**footer, **changed}).encode()
    body = data[:start] + text + struct.pack("<QQ", start, len(text))
    return body + hashlib.sha256(body).digest()


HOSTILE = {
    "no rig": {"rig": []},
    "a rig of texts": {"rig": ["a", "b"]},
    "no events": {"events": []},
    "a million events": {"events": [["x"] * 101] * 4},
    "other blocks": {"block_sizes": [1, 2, 3]},
    "huge blocks": {"block_sizes": [2**40] * 11},
    "an endless rate": {"fps": 1e308},
    "a rate of text": {"fps": "3"},
    "a negative seed": {"seed": -1},
    "a sensor's unknown field": {"sensor": {"white_balance_rgb": [1, 1, 1], "__class__": 1}},
    "another version": {"version": 99},
    "a long renderer": {"renderer": "x" * 1000},
    "a key of text": {"key": "x"},
}


@pytest.mark.parametrize("changed", HOSTILE.values(), ids=HOSTILE)
def test_a_forged_footer_is_refused_in_one_line(made, tmp_path, changed):
    path = tmp_path / "a.rec"
    path.write_bytes(forged(made[0].read_bytes(), **changed))
    with pytest.raises(FileError, match="is a damaged recording") as fault:
        Recording(path)
    assert "\n" not in str(fault.value)


def test_cameras_of_another_size_unpack_nothing_larger(made, tmp_path):
    path = tmp_path / "a.rec"
    data = made[0].read_bytes()
    start, length, _ = TAIL.unpack(data[-TAIL.size :])
    rig = json.loads(data[start : start + length])["rig"]
    path.write_bytes(forged(data, rig=[{**camera, "width_px": 48} for camera in rig]))
    with Recording(path) as recording, pytest.raises(FileError, match="changed while it was read"):
        next(iter(recording.frames()))
    path.write_bytes(forged(data, rig=[{**camera, "width_px": 5000} for camera in rig]))
    with pytest.raises(FileError, match="is a damaged recording"):
        Recording(path)
    assert data.startswith(MAGIC)


def test_a_disk_that_refuses_ends_the_recording_alone(tmp_path):
    class Full:
        def write(self, data):
            raise OSError(28, "No space left on device")

    with Simulation(replace(PERFORMANCE, frames=2)) as simulation:
        recorded = RecordedSimulation(simulation, Full(), KEY)
        assert len(list(recorded.frames())) == 2
        assert not recorded.complete
