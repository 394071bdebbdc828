"""A tracker on kept detections gives what it gives on pictures, and nothing is kept too long."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from pjpdaf.detector.blob_detector import BlobDetector
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.interfaces import Estimates
from pjpdaf.plugins.checked import CheckedDetector
from reports.run.rows import rows_of
from reports.run.stored_rows import rows_to_bytes
from scenarios.cache.folder import CacheFolder, Kind
from scenarios.cache.report import required_settings
from scenarios.cache.settings import FOLDER_VARIABLE
from scenarios.play.footage import open_footage
from scenarios.play.job import Job, System
from scenarios.play.kept_detections import KeptDetections
from scenarios.play.play import make_system, play_complete, play_footage
from scenarios.spec.names import load_scenario
from sim.recording.pictures import PictureDecoder
from sim.sequence import Simulation

JOB = Job(
    load_scenario("cross"),
    6,
    {"frames": 5, "background_frames": 10, "dropped": 0.1},
    System(),
    keep_film=True,
    size_px=(160, 120),
)
PRESETS = ("default", "thesis")


def of(detector, tracker=None, **changed):
    system = System(detector, tracker or detector)
    return replace(JOB, system=system, **changed)


def same(one, other):
    """Whether all that a run keeps is the same, byte for byte."""
    rows = (replace(rows_of(e), stage_s={}, replayed=False) for e in (one, other))
    first, second = (rows_to_bytes(replace(row, detections_kept=False)) for row in rows)
    return first == second


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A cache with footage, film and both presets' detections; and what was played."""
    folder = tmp_path_factory.mktemp("filled") / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(folder))
        return folder, {preset: play_complete(of(preset)) for preset in PRESETS}


@pytest.fixture
def folder(filled, tmp_path, monkeypatch):
    """A copy of the filled cache."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "cache"))
    return Path(shutil.copytree(filled[0], tmp_path / "cache"))


def files(kind):
    return [e.path for e in CacheFolder(required_settings()).entries() if e.kind == kind]


def refused(*arguments):
    raise AssertionError("nothing is rendered, read or detected")


def refuse(patch, *methods):
    for owner, name in methods:
        patch.setattr(owner, name, refused)


DETECTING = ((BlobDetector, "detect"), (BlobDetector, "learn"), (SkinDetector, "detect"))
READING = ((PictureDecoder, "decode"), (Simulation, "__init__"))


def test_the_same_tracker_reads_no_picture_and_gives_the_same(folder, filled, monkeypatch):
    assert [len(files(kind)) for kind in Kind] == [1, 2, 1, 1]
    refuse(monkeypatch, *DETECTING, *READING)
    for preset, first in filled[1].items():
        again = play_complete(of(preset))
        assert again.detections_kept
        assert not first.detections_kept
        assert same(again, first)
        assert len(again.film) == len(again.frames)
        # The times are those of the detector, when it detected.
        times = [[o.stage_s["detect"] for o in e.frames] for e in (again, first)]
        assert all(0 < kept_s <= all_s for kept_s, all_s in zip(*times, strict=True))


@pytest.mark.parametrize("detector", PRESETS)
def test_another_tracker_gives_what_it_gives_on_the_pictures(folder, detector, monkeypatch):
    other = "thesis" if detector == "default" else "default"
    job = of(detector, other, keep_pictures=True)
    kept = play_complete(job)
    assert kept.replayed
    assert kept.pictures
    for kind in (Kind.DETECTIONS, Kind.FILMS):
        for path in files(kind):
            path.unlink()
    anew = play_complete(job)
    assert anew.replayed
    assert not anew.detections_kept
    assert same(kept, anew)


def test_what_a_prediction_changes_is_detected_again_and_kept(folder):
    with open_footage(of("default")) as footage:
        detector, _ = make_system(JOB.system, footage.calibration)
        learnt = detector.learn(footage.background())
        frames = [
            frame for frame, _ in footage.frames() if all(p is not None for p in frame.pictures)
        ]
        # Nothing is as far away as this, or as near: the smallest area is another.
        far, near = (
            replace(
                Estimates.waiting(),
                positions_m=[[x, 0.0, 1.0]] * 3,
                status=("tracked",) * 3,
            )
            for x in (-3.0, 0.9)
        )
        kept = KeptDetections(detector, lambda: learnt, {})
        for frame in frames:
            for predicted in (far, near, far, near):
                given, expected = kept(frame, predicted), learnt(frame, predicted)
                for mine, theirs in zip(given, expected, strict=True):
                    assert mine.centres_px.tobytes() == theirs.centres_px.tobytes()
                    assert mine.areas_px.tobytes() == theirs.areas_px.tobytes()
        assert len(frames) < kept.added <= 2 * len(frames)


def test_damaged_files_are_made_anew(folder, filled):
    (film,) = files(Kind.FILMS)
    for path in (film, *files(Kind.DETECTIONS)):
        path.write_bytes(path.read_bytes()[:-1])
    again = play_complete(of("default"))
    assert not again.detections_kept
    assert same(again, filled[1]["default"])
    assert play_complete(of("default")).detections_kept


def test_detections_of_other_parameters_are_not_given(folder):
    job = replace(JOB, system=System("default", "default", {"open_px": "5"}))
    assert not play_complete(job).detections_kept
    assert len(files(Kind.DETECTIONS)) == 3
    assert play_complete(job).detections_kept


def test_what_a_plug_in_detects_is_not_kept(folder):
    for path in files(Kind.DETECTIONS):
        path.unlink()
    with open_footage(JOB) as footage:
        detector, tracker = make_system(JOB.system, footage.calibration)
        plugged = CheckedDetector("mine", detector, 2)
        episode = play_footage(JOB, footage, plugged, tracker)
    assert not episode.detections_kept
    assert files(Kind.DETECTIONS) == []


def test_a_run_that_fails_keeps_no_detections(folder):
    for path in files(Kind.DETECTIONS):
        path.unlink()

    def fails(step, truth):
        raise RuntimeError(step.frame.index)

    with open_footage(JOB) as footage, pytest.raises(RuntimeError):
        play_footage(JOB, footage, *make_system(JOB.system, footage.calibration), fails)
    assert files(Kind.DETECTIONS) == []
