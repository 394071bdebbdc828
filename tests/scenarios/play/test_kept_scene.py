"""What a detector sees in the empty room is kept apart: another detector takes it from there."""

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.detector.alignment import Alignment
from pjpdaf.detector.exposure import Exposure
from pjpdaf.detector.still_scene import StillScene, still_scene
from reports.run.rows import rows_of
from reports.run.stored_rows import rows_to_bytes
from scenarios.cache.folder import CacheFolder, Kind
from scenarios.cache.report import required_settings
from scenarios.cache.settings import FOLDER_VARIABLE
from scenarios.play import kept_scene
from scenarios.play.footage import key_of, open_footage
from scenarios.play.job import Job, System
from scenarios.play.kept_scene import KeptScene, scene_from_arrays, scene_to_arrays
from scenarios.play.play import make_system, play
from scenarios.spec.names import load_scenario

# Cameras that were bumped after calibration, and noise enough to be smoothed.
VALUES = {"frames": 2, "background_frames": 10, "noise_sd": 12.0, "calibration_rot_x": 0.8}
JOB = Job(load_scenario("cross"), 1, VALUES, System(), size_px=(320, 240))
NARROWER = {"close_px": "7"}


def kept():
    entries = CacheFolder(required_settings()).entries()
    return [entry.path for entry in entries if entry.kind == Kind.SCENES]


def content(job):
    rows = rows_of(play(job))
    return rows_to_bytes(replace(rows, stage_s={}, replayed=False, detections_kept=False))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A cache with the footage."""
    path = tmp_path_factory.mktemp("scene") / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(path))
        play(JOB)
        yield path


def refused(*arguments, **parts):
    raise AssertionError("the scene is looked at again")


def test_another_detector_takes_the_scene_from_the_cache(folder, monkeypatch):
    other = replace(JOB, system=System(detector_settings=NARROWER))
    (path,) = kept()
    with monkeypatch.context() as patch:
        patch.setattr(kept_scene, "still_scene", refused)
        again = content(other)
    with monkeypatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, "off")
        assert content(other) == again
    assert kept() == [path]


def test_one_that_looks_otherwise_looks_itself(folder, monkeypatch):
    monkeypatch.setattr(kept_scene, "still_scene", refused)
    for part in ("smooth_noise", "align_views"):
        job = replace(JOB, system=System(detector_settings={part: "false"}))
        with pytest.raises(AssertionError, match="looked at again"):
            play(job)


def test_a_damaged_scene_is_looked_at_again(folder):
    with open_footage(JOB) as footage:
        cameras = footage.calibration.cameras
        scene = still_scene(footage.background(), cameras, smooth_noise=True, align_views=True)
        assert scene.alignment is not None
        assert all(exposure.blur_px > 0 for exposure in scene.exposures)
        place = KeptScene(required_settings(), key_of(JOB), footage)
        (path,) = kept()
        whole = path.read_bytes()
        for damaged in (whole[:-1], b""):
            path.write_bytes(damaged)
            learnt = place.learnt(make_system(JOB.system, footage.calibration)[0])
            assert learnt.exposures == scene.exposures
            assert learnt.alignment.rotation.tobytes() == scene.alignment.rotation.tobytes()
            assert path.read_bytes() == whole


TURN = Alignment(np.array([1e-3, -2e-3, 3e-9]), np.array([1e-4, 2e-4, 3e-4]), 321)


@pytest.mark.parametrize("turn", [TURN, None], ids=["turned", "straight"])
def test_a_scene_is_the_same_after_it_was_kept(turn):
    scene = StillScene((Exposure(0.1 + 0.2), Exposure()), turn)
    exposures, back = scene_from_arrays(scene_to_arrays(scene), 2)
    assert exposures == scene.exposures
    if turn is None:
        assert back is None
    else:
        assert back.rotation.tobytes() == turn.rotation.tobytes()
        assert back.deviations.tobytes() == turn.deviations.tobytes()
        assert back.points == turn.points


def test_arrays_of_another_kind_are_no_scene():
    arrays = scene_to_arrays(StillScene((Exposure(), Exposure()), TURN))
    for changed in (
        {**arrays, "blurs_px": np.zeros(3)},
        {**arrays, "turns": np.zeros((2, 2, 3)), "points": np.zeros(2, np.int32)},
        {**arrays, "turns": np.zeros((1, 3))},
        {name: array for name, array in arrays.items() if name != "points"},
    ):
        with pytest.raises(ValueError):
            scene_from_arrays(changed, 2)
