"""`track` as users start it, on footage that sim rendered, against sim's truth."""

import csv
import dataclasses
import importlib.util
import json
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import cv2
import numpy as np
import pandas as pd
import pytest
from commands import ENVIRONMENT, ROOT, command, in_this_process

from pjpdaf.calibration import write_rig
from pjpdaf.camera import StereoRig, distort_points, project, to_camera
from pjpdaf.targets import TARGETS
from reports.footage.tracks import COLUMNS
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.sequence import Simulation

FRAMES = 12
LENS = (-0.12, 0.04, 0.0005, -0.0004, 0.0)
HEADER = (
    "frame,time_s,target,x_m,y_m,z_m,status,u_left_px,v_left_px,u_right_px,v_right_px,"
    "sd_x_m,sd_y_m,sd_z_m,exchange_probability"
)


def in_left_camera(rig):
    """The rig with the left camera's frame as its world."""
    left = dataclasses.replace(rig.left, R_cw=np.eye(3), t_cw=np.zeros(3))
    return StereoRig(left, dataclasses.replace(rig.right, R_cw=rig.R, t_cw=rig.T))


@pytest.fixture(scope="module")
def footage(tmp_path_factory):
    """Folders left, right, bl, br of a rendered sequence seen through a lens; truth_m (F, T, 3)."""
    folder = tmp_path_factory.mktemp("footage")
    performance = perform(load_scenario("calm_table"), 0, {"frames": str(FRAMES)})
    rig = dataclasses.replace(performance.scene.rig, distortion=LENS)
    scene = dataclasses.replace(performance.scene, rig=rig)
    performance = dataclasses.replace(performance, scene=scene)
    truth = []
    with Simulation(performance) as simulation:
        for names, frames in (
            (("bl", "br"), simulation.background()),
            (("left", "right"), simulation.frames()),
        ):
            for name in names:
                (folder / name).mkdir()
            for item in frames:
                frame, true = item if isinstance(item, tuple) else (item, None)
                for name, picture in zip(names, frame.pictures, strict=True):
                    assert cv2.imwrite(str(folder / name / f"{frame.index:03d}.png"), picture)
                if true is not None:
                    truth.append(to_camera(simulation.rig.left, true.centres_m))
        write_rig(simulation.rig, folder / "cal")
        return SimpleNamespace(
            folder=folder, truth_m=np.array(truth), rig=in_left_camera(simulation.rig)
        )


def words(footage, out, **changes):
    """Words of a whole command; a change to None leaves its option out."""
    f = footage.folder
    options = {
        "left": f / "left",
        "right": f / "right",
        "calibration": (f / "cal/intrinsics.yml", f / "cal/extrinsics.yml"),
        "background-left": f / "bl",
        "background-right": f / "br",
        "out": out,
    } | {key.replace("_", "-"): value for key, value in changes.items()}
    line = ["track"]
    for key, value in options.items():
        values = () if value is None else value if isinstance(value, tuple) else (value,)
        line += [f"--{key}", *map(str, values)] if values else []
    return line


def track(footage, out, **changes):
    return in_this_process(*words(footage, out, **changes))


def links(folder, files):
    """A folder of links 000.png, 001.png, ... to files; None leaves a number out."""
    folder.mkdir(parents=True)
    for i, file in enumerate(files):
        if file is not None:
            (folder / f"{i:05d}.png").symlink_to(file)
    return folder


def pictures(footage, name):
    return sorted((footage.folder / name).iterdir())


def errors_mm(tracks, truth_m):
    """Distance of every estimate from the truth (frames, targets) [mm]."""
    positions = tracks[["x_m", "y_m", "z_m"]].to_numpy().reshape(-1, len(TARGETS), 3)
    return 1000 * np.linalg.norm(positions - truth_m, axis=2)


@pytest.fixture(scope="module")
def tracked(footage):
    out = footage.folder / "out"
    done = track(footage, out)
    assert done.returncode == 0, done.stderr
    return SimpleNamespace(out=out, stdout=done.stdout, stderr=done.stderr)


def test_the_tracks_are_those_of_the_simulation(footage, tracked):
    assert tracked.stderr.strip() == ""
    lines = (tracked.out / "tracks.csv").read_text().splitlines()
    assert lines[0] == HEADER == ",".join(COLUMNS)
    assert len(lines) == 1 + FRAMES * len(TARGETS)
    tracks = pd.read_csv(tracked.out / "tracks.csv")
    assert tracks["frame"].tolist() == [i for i in range(FRAMES) for _ in TARGETS]
    assert tracks["target"].tolist() == list(TARGETS) * FRAMES
    np.testing.assert_allclose(tracks["time_s"], tracks["frame"] / 3, atol=1e-6)
    errors = errors_mm(tracks, footage.truth_m)
    # The centre of the visible skin is tracked, the truth is the body's centre: 20-30 mm apart.
    assert (np.median(errors, axis=0) < 40).all(), np.median(errors, axis=0)
    assert set(tracks["status"]) == {"tracked"}
    assert (tracks[["sd_x_m", "sd_y_m", "sd_z_m"]] > 0).all(axis=None)


def test_pixels_are_those_of_the_real_picture(footage, tracked):
    tracks = pd.read_csv(tracked.out / "tracks.csv")
    points = tracks[["x_m", "y_m", "z_m"]].to_numpy()
    for view, camera in zip(("left", "right"), footage.rig.cameras, strict=True):
        ideal = project(camera, points)
        said = tracks[[f"u_{view}_px", f"v_{view}_px"]].to_numpy()
        np.testing.assert_allclose(said, distort_points(camera, ideal), atol=0.01)
        assert np.abs(said - ideal).max() > 0.5  # the lens does something here


def test_parquet_has_the_same_rows(tracked):
    tracks = pd.read_csv(tracked.out / "tracks.csv")
    table = pd.read_parquet(tracked.out / "tracks.parquet")
    assert list(table.columns) == list(COLUMNS)
    for name in COLUMNS:
        if table[name].dtype == float:
            np.testing.assert_allclose(table[name], tracks[name], atol=1e-3)
        else:
            assert table[name].tolist() == tracks[name].tolist()


def test_film_page_and_facts(tracked):
    names = {file.name for file in tracked.out.iterdir()}
    film = "overlay.mp4" if importlib.util.find_spec("av") else "overlay.webm"
    assert names == {"tracks.csv", "tracks.parquet", "report.html", "track.json", film}
    assert not list(tracked.out.parent.glob(".out.part*"))
    capture = cv2.VideoCapture(str(tracked.out / film))
    assert capture.get(cv2.CAP_PROP_FPS) == pytest.approx(3.0)
    sizes = []
    while (read := capture.read())[0]:
        sizes.append(read[1].shape)
    capture.release()
    assert sizes == [(510, 1284, 3)] * FRAMES
    page = (tracked.out / "report.html").read_text()
    for fragment in ("Found from the first frame on", 'class="chart"', "data:image/jpeg"):
        assert fragment in page
    assert "http://" not in page
    assert "<script src" not in page
    assert '<link rel="stylesheet' not in page
    facts = json.loads((tracked.out / "track.json").read_text())
    assert facts["complete"]
    assert facts["frames"] == FRAMES
    assert facts["targets"]["head"]["tracked"] == FRAMES
    assert "right hand" in tracked.stdout
    assert "report.html" in tracked.stdout


def test_corrupt_and_missing_pictures_are_named_and_missed(footage, tmp_path):
    left = links(
        tmp_path / "left", [*pictures(footage, "left")[:5], None, *pictures(footage, "left")[6:8]]
    )
    right = links(tmp_path / "right", pictures(footage, "right")[:8])
    (right / "00003.png").unlink()
    (right / "00003.png").write_bytes(pictures(footage, "right")[3].read_bytes()[:2000])
    done = track(footage, tmp_path / "out", left=left, right=right, preset="thesis")
    assert done.returncode == 0, done.stderr
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 2, done.stderr
    assert str(right / "00003.png") in lines[0]
    assert "counts as missing" in lines[0]
    assert "left: no picture belongs to" in lines[1]
    assert "00005.png" in lines[1]
    tracks = pd.read_csv(tmp_path / "out/tracks.csv")
    assert len(tracks) == 8 * len(TARGETS)
    for frame, status in tracks.groupby("frame")["status"]:
        assert set(status) == ({"coasting"} if frame in (3, 5) else {"tracked"})
    page = (tmp_path / "out/report.html").read_text()
    assert "Pictures missing in frames 3, 5" in page
    assert "picture missing" in page


def test_waiting_rows_are_empty_and_the_first_frames_are_the_background(footage, tmp_path):
    empty = 10
    left = links(tmp_path / "left", [*pictures(footage, "bl"), *pictures(footage, "left")[:4]])
    right = links(tmp_path / "right", [*pictures(footage, "br"), *pictures(footage, "right")[:4]])
    none = {"background_left": None, "background_right": None}
    done = track(footage, tmp_path / "out", left=left, right=right, background_first=empty, **none)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "out/tracks.csv").read_text().splitlines()))
    assert len(rows) == (empty + 4) * len(TARGETS)
    for row in rows[: empty * len(TARGETS)]:
        assert row["status"] == "waiting"
        assert {row[name] for name in COLUMNS if name.endswith(("_m", "_px"))} == {""}
    later = pd.DataFrame(rows[empty * len(TARGETS) :])
    errors = errors_mm(
        later.astype({"x_m": float, "y_m": float, "z_m": float}), footage.truth_m[:4]
    )
    assert np.median(errors) < 40
    assert "since tracking began in frame 10" in (tmp_path / "out/report.html").read_text()


def test_videos_settings_rate_unit_and_skin_sample(footage, tmp_path):
    for name in ("left", "right", "bl", "br"):
        writer = cv2.VideoWriter(
            str(tmp_path / f"{name}.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 3.0, (640, 480)
        )
        for file in pictures(footage, name)[:10]:
            writer.write(cv2.imread(str(file)))
        writer.release()
    # The sample's own files: T in millimetres, no size, no rectification.
    rig = footage.rig
    mm = StereoRig(rig.left, dataclasses.replace(rig.right, t_cw=1000 * rig.right.t_cw))
    inner, outer = write_rig(mm, tmp_path / "cal")
    inner.write_text("".join(s for s in inner.read_text().splitlines(True) if "image_" not in s))
    outer.write_text(outer.read_text().partition("R1:")[0])
    first = cv2.imread(str(pictures(footage, "left")[0]))
    u, v = np.round(distort_points(rig.left, project(rig.left, footage.truth_m[0, :1])))[0]
    cv2.imwrite(
        str(tmp_path / "skin.png"), first[int(v) + 10 : int(v) + 30, int(u) - 8 : int(u) + 8]
    )
    done = track(
        footage,
        tmp_path / "out",
        left=tmp_path / "left.avi",
        right=tmp_path / "right.avi",
        background_left=tmp_path / "bl.avi",
        background_right=tmp_path / "br.avi",
        calibration=(inner, outer),
        unit="mm",
        fps=6,
        preset="thesis",
        set="tracker.p_detect=0.8",
        skin_sample=tmp_path / "skin.png",
    )
    assert done.returncode == 0, done.stderr
    tracks = pd.read_csv(tmp_path / "out/tracks.csv")
    assert tracks["time_s"].iloc[-1] == pytest.approx(9 / 6)
    assert (np.median(errors_mm(tracks, footage.truth_m[:10]), axis=0) < 50).all()
    changed = json.loads((tmp_path / "out/track.json").read_text())["changed"]
    assert {"tracker.p_detect", "detector.hue_range_deg"} <= set(changed)


@pytest.mark.long
def test_skin_learnt_from_the_head(footage, tmp_path):
    out = tmp_path / "out"
    setting = "detector.value_min=0.15"
    done = track(footage, out, skin_sample="head", set=setting, preset="thesis-literal")
    assert done.returncode == 0, done.stderr
    parameters = json.loads((out / "track.json").read_text())["parameters"]
    low, high = parameters["detector.hue_range_deg"]
    assert 2 < low < 12
    assert 25 < high < 45
    assert parameters["detector.value_min"] == 0.15  # what is given wins
    assert set(pd.read_csv(out / "tracks.csv")["status"]) != {"waiting"}


@pytest.fixture(scope="module")
def odd(footage):
    """Folders that something is wrong with."""
    folder = footage.folder / "odd"
    folder.mkdir()
    (folder / "empty").mkdir()
    small = folder / "small"
    small.mkdir()
    for file in pictures(footage, "left")[:3]:
        cv2.imwrite(str(small / file.name), cv2.imread(str(file))[::2, ::2])
    links(folder / "short", pictures(footage, "left")[:3])
    colours = cv2.imread(str(pictures(footage, "left")[0]))
    grey = cv2.cvtColor(colours, cv2.COLOR_BGR2GRAY)
    for name, picture in (("grey", grey), ("ten", colours.astype(np.uint16) * 4)):
        for view in (name, f"{name}_too"):
            (folder / view).mkdir()
            cv2.imwrite(str(folder / view / "0.png"), picture)
    (folder / "text.yml").write_text("hello")
    (folder / "text.avi").write_text("hello")
    taken = folder / "taken"
    taken.mkdir()
    (taken / "keep").write_text("mine")
    return folder


FAULTS = [
    ({"left": "empty"}, ("empty", "no pictures")),
    ({"left": "nowhere"}, ("nowhere", "no such file or folder")),
    ({"left": "text.avi"}, ("text.avi", "not a video")),
    ({"left": "short"}, ("differ in length", "3 pictures", "12")),
    ({"left": "short"}, ("--shortest leaves out",)),
    ({"right": None}, ("is one view", "--stereo side-by-side")),
    (
        {"stereo": "stacked"},
        ("--stereo stacked: no such layout; known: separate, side-by-side, top-bottom",),
    ),
    ({"left": "grey", "right": "grey_too"}, ("the pictures are grey",)),
    ({"left": "ten", "right": "ten_too"}, ("16 bits whose values use 10",)),
    ({"left": "small", "right": "short"}, ("640x480", "320x240")),
    ({"background_left": "small"}, ("000.png", "320x240", "640x480")),
    ({"background_left": None, "background_right": None}, ("--background-first",)),
    (
        {"left": "nowhere", "background_left": None, "background_right": None},
        ("nowhere", "no such file or folder"),
    ),
    ({"background_right": None}, ("both",)),
    ({"background_first": 5}, ("not both",)),
    ({"background_left": None, "background_right": None, "background_first": 99}, ("only 12",)),
    ({"background_left": None, "background_right": None, "background_first": 4}, ("10", "got 4")),
    ({"calibration": ("text.yml", "text.yml")}, ("text.yml", "not a calibration file")),
    ({"calibration": ("nowhere.yml", "text.yml")}, ("nowhere.yml", "no such calibration file")),
    ({"preset": "thesiss"}, ("thesiss", "Did you mean 'thesis'?")),
    ({"detector": "nowhere:make"}, ("nowhere",)),
    ({"set": "speed=3"}, ("speed", "detector.NAME")),
    ({"preset": "thesis", "set": "tracker.p_detekt=1"}, ("p_detekt", "p_detect")),
    ({"fps": 0}, ("--fps",)),
    ({"preset": "thesis", "lag": 2}, ("--lag 2", "'thesis' does not look back")),
    ({"lag": -1}, ("--lag", "from 0 to 60 frames, got -1")),
    ({"unit": "miles"}, ("--unit", "miles")),
    ({"skin_sample": "nowhere.png"}, ("nowhere.png",)),
    ({"skin_sample": "text.yml"}, ("text.yml", "cannot be read")),
    ({"out": "taken"}, ("taken", "not empty")),
    ({"out": "taken/keep"}, ("keep", "is a file")),
]


@pytest.mark.parametrize(
    ("changes", "fragments"), FAULTS, ids=[" ".join(map(str, c.items())) for c, _ in FAULTS]
)
def test_a_fault_is_one_line_and_nothing_is_written(footage, odd, changes, fragments):
    def path(key, value):
        if isinstance(value, tuple):
            return tuple(odd / v for v in value)
        named = key in ("left", "right", "calibration", "skin_sample", "out") or "_" in key
        return odd / value if named and isinstance(value, str) else value

    changes = {key: path(key, value) for key, value in changes.items()}
    out = changes.pop("out", odd / "out")
    before = sorted(odd.rglob("*"))
    done = track(footage, out, **changes)
    assert done.returncode == 2
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, lines
    for fragment in fragments:
        assert fragment in lines[0]
    assert sorted(odd.rglob("*")) == before


def test_both_views_in_one_picture_without_a_background(footage, tmp_path):
    (tmp_path / "both").mkdir()
    for files in zip(pictures(footage, "left"), pictures(footage, "right"), strict=True):
        both = np.hstack([cv2.imread(str(file)) for file in files])
        cv2.imwrite(str(tmp_path / "both" / files[0].name), both)
    command = words(
        footage,
        tmp_path / "out",
        left=tmp_path / "both",
        right=None,
        stereo="side-by-side",
        background_left=None,
        background_right=None,
        preset="thesis",
    )
    done = in_this_process(*command, "--no-background")
    assert done.returncode == 0, done.stderr
    assert "--no-background: everything of the colour of skin is taken for skin" in done.stderr
    tracks = pd.read_csv(tmp_path / "out" / "tracks.csv")
    assert len(tracks) == FRAMES * len(TARGETS)
    # The room of this scenario has nothing of the colour of skin.
    assert np.nanmedian(errors_mm(tracks, footage.truth_m)) < 60


def test_a_fault_in_mid_footage_keeps_what_was_tracked(footage, tmp_path):
    files = pictures(footage, "right")
    odd = tmp_path / "odd.png"
    assert cv2.imwrite(str(odd), cv2.imread(str(files[7]))[:400])
    left = links(tmp_path / "left", pictures(footage, "left"))
    right = links(tmp_path / "right", [*files[:7], odd, *files[8:]])
    done = track(footage, tmp_path / "out", left=left, right=right, preset="thesis")
    assert done.returncode == 2
    (line,) = done.stderr.strip().splitlines()
    assert "00007.png: the picture is 640x400 px" in line
    assert "the first 7 frames are saved in" in line
    tracks = pd.read_csv(tmp_path / "out" / "tracks.csv")
    assert len(tracks) == 7 * len(TARGETS)
    assert "Incomplete" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_keeps_what_is_tracked(footage, tmp_path, number):
    files = {name: pictures(footage, name) * 40 for name in ("left", "right")}
    sides = {name: links(tmp_path / name, paths) for name, paths in files.items()}
    out = tmp_path / "out"
    process = subprocess.Popen(
        command(*words(footage, out, **sides)),
        cwd=ROOT,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while True:
        assert process.poll() is None
        part = next(iter(tmp_path.glob(".out.part-*/tracks.csv")), None)
        if part is not None and part.read_text().count("\n") > 20:
            break
        time.sleep(0.02)
    assert not out.exists()
    process.send_signal(number)
    _, stderr = process.communicate(timeout=120)
    assert process.returncode == 130, stderr
    assert "interrupted: the first" in stderr
    assert "Traceback" not in stderr
    tracks = pd.read_csv(out / "tracks.csv")
    frames = tracks["frame"].max() + 1
    assert 6 < frames < 480
    assert len(tracks) == frames * len(TARGETS)
    assert len(pd.read_parquet(out / "tracks.parquet")) == len(tracks)
    assert "Incomplete" in (out / "report.html").read_text()
    assert not list(tmp_path.glob(".out.part*"))


def test_footage_without_a_person(footage, tmp_path):
    f = footage.folder
    done = track(footage, tmp_path / "out", left=f / "bl", right=f / "br")
    assert done.returncode == 0, done.stderr
    assert "Tracking never began" in done.stdout
    assert "--skin-sample" in done.stdout
    page = (tmp_path / "out/report.html").read_text()
    assert "Tracking never began" in page
    assert 'data-figure="time-0"' not in page
    assert set(pd.read_csv(tmp_path / "out/tracks.csv")["status"]) == {"waiting"}


RSS = (
    "import resource, sys; sys.argv = ['pjpdaf-bench', *sys.argv[1:]];"
    "from scenarios.cli.main import main\n"
    "try: main()\n"
    "finally: print('peak', resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
)


@pytest.mark.long
def test_memory_does_not_grow_with_the_length(footage, tmp_path):
    peaks_mb = {}
    for frames in (500, 5000):
        sides = {
            name: links(
                tmp_path / f"{name}{frames}",
                [pictures(footage, name)[i % FRAMES] for i in range(frames)],
            )
            for name in ("left", "right")
        }
        line = words(footage, tmp_path / f"out{frames}", **sides)
        done = subprocess.run(
            [sys.executable, "-c", RSS, *line],
            cwd=ROOT,
            env=ENVIRONMENT,
            capture_output=True,
            text=True,
            check=True,
        )
        peaks_mb[frames] = int(done.stdout.split()[-1]) / 1024
        table = pd.read_csv(tmp_path / f"out{frames}/tracks.csv")
        assert len(table) == frames * len(TARGETS)
    print(peaks_mb)
    # A frame's pictures alone are 1.8 MB: kept, 4500 of them would be 8 GB. What does grow: the
    # list of file names (10 000 paths, about 10 MB).
    assert peaks_mb[5000] < peaks_mb[500] + 40, peaks_mb
