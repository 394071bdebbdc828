"""`scenarios show --film`, as users start it."""

import shutil
import signal
import subprocess
import sys
import time

import cv2
import pytest
from commands import ENVIRONMENT, ROOT, command, in_this_process

from pjpdaf.errors import BenchError
from reports.pictures.truth_overlay import STRIP_PX
from scenarios.catalogue.film import parse_frame_range


@pytest.mark.parametrize(
    ("words", "first", "last"),
    [(None, 0, 47), ("10:30", 10, 30), (":5", 0, 5), ("40:", 40, 47), ("7:7", 7, 7)],
)
def test_frames_are_given_by_the_first_and_the_last(words, first, last):
    assert list(parse_frame_range(words, 48)) == list(range(first, last + 1))


@pytest.mark.parametrize("words", ["5", "a:b", "5:3", "-3:5", "0:48", "", "1:2:3"])
def test_odd_frames_are_one_line(words):
    with pytest.raises(BenchError, match="--frames"):
        parse_frame_range(words, 48)


def test_a_film_has_every_frame_with_its_truth(tmp_path):
    pytest.importorskip("av")
    film = tmp_path / "my.cross.mp4"
    words = ("scenarios", "show", "cross", "--film", film)
    done = in_this_process(*words, "--seed", 100, "--frames", "12:16")
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"film: {film} (5 frames at 3 a second)\n"
    assert done.stderr.strip() == ""
    assert [file.name for file in tmp_path.iterdir()] == [film.name]
    capture = cv2.VideoCapture(str(film))
    assert capture.get(cv2.CAP_PROP_FPS) == pytest.approx(3.0)
    assert capture.get(cv2.CAP_PROP_FOURCC) == cv2.VideoWriter.fourcc(*"h264")
    frames = []
    while (read := capture.read())[0]:
        frames.append(read[1])
    capture.release()
    assert [frame.shape for frame in frames] == [(480 + STRIP_PX, 1284, 3)] * 5
    assert (frames[0] != frames[4]).any()
    again = in_this_process(*words)
    assert again.returncode == 2
    assert "exists; give another name" in again.stderr


@pytest.mark.long
def test_a_sheet_has_frames_of_the_whole_and_takes_settings(tmp_path):
    sheet = tmp_path / "sheet.PNG"
    words = ("scenarios", "show", "drink", "--set", "frames=6", "--seed", 100, "--film", sheet)
    done = in_this_process(*words)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"sheet: {sheet} (frames 0, 1, 2, 3, 4, 5)\n"
    picture = cv2.imread(str(sheet))
    assert picture.shape[1] > 1800
    assert picture.shape[0] > 1000
    assert picture.std() > 20
    assert [file.name for file in tmp_path.iterdir()] == [sheet.name]


FAULTS = [
    (("cross", "--film", "out.gif"), ("out.gif", ".mp4", ".png")),
    (("cross", "--film", "out"), (".mp4", ".png")),
    (("crss", "--film", "out.png"), ("did you mean cross?",)),
    (("cross", "--film", "no/out.png"), ("out.png", "the sheet", "Make its folder first")),
    (("cross", "--film", "taken.png"), ("taken.png", "exists")),
    (("cross", "--film", "folder.png"), ("folder.png", "is a folder")),
    (("cross", "--film", "taken.png/out.png"), ("the sheet", "Not a directory")),
    (("cross", "--film", "out.png", "--frames", "4:999"), ("--frames 4:999", "must lie in 0:")),
    (("cross", "--film", "out.png", "--set", "speeed=1"), ("speeed", "did you mean speed?")),
    (("cross", "--film", "out.png", "--set", "tracker.gate=1"), ("tracker.gate",)),
    (("cross", "--film", "out.png", "--seed", "-1"), ("seed",)),
    (("cross", "--frames", "1:2"), ("--film",)),
    (("cross", "--set", "tracker.gate=1"), ("tracker.gate",)),
]


@pytest.mark.parametrize(("words", "fragments"), FAULTS, ids=[" ".join(w) for w, _ in FAULTS])
def test_a_fault_is_one_line_and_nothing_is_left(words, fragments, tmp_path, monkeypatch):
    (tmp_path / "taken.png").write_text("mine")
    (tmp_path / "folder.png").mkdir()
    monkeypatch.chdir(tmp_path)
    done = in_this_process("scenarios", "show", *words)
    assert done.returncode == 2
    (line,) = done.stderr.strip().splitlines()
    for fragment in fragments:
        assert fragment in line, line
    assert sorted(f.name for f in tmp_path.rglob("*")) == ["folder.png", "taken.png"]
    assert (tmp_path / "taken.png").read_text() == "mine"


def test_without_the_extra_a_film_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    words = ("scenarios", "show", "cross", "--film", tmp_path / "out.mp4")
    done = in_this_process(*words)
    assert done.returncode == 5
    (line,) = done.stderr.strip().splitlines()
    assert "pjpdaf-bench[video]" in line
    assert list(tmp_path.iterdir()) == []


def can_mount():
    if shutil.which("unshare") is None:
        return False
    words = ["unshare", "-Urm", "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(words, capture_output=True, check=False).returncode == 0


@pytest.mark.long
@pytest.mark.skipif(not can_mount(), reason="a small disk cannot be mounted here")
def test_a_full_disk_is_one_line_and_exit_code_5(tmp_path):
    pytest.importorskip("av")
    show = f'{" ".join(command())} scenarios show cross --frames 0:2 --film "$0/out.mp4"'
    script = f'mount -t tmpfs -o size=16k none "$0" && {{ {show}; echo "rc $?"; ls -A "$0"; }}'
    done = subprocess.run(
        ["unshare", "-Urm", "sh", "-c", script, str(tmp_path)],
        cwd=ROOT,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "rc 5\n", done.stderr
    (line,) = done.stderr.strip().splitlines()
    assert f"{tmp_path}/out.mp4: cannot write the film" in line
    assert "No space left on device. Free some space there" in line


@pytest.mark.long
@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_an_interrupted_film_leaves_nothing(tmp_path, number):
    pytest.importorskip("av")
    line = command("scenarios", "show", "calm_table", "--film", str(tmp_path / "out.mp4"))
    with subprocess.Popen(
        line, cwd=ROOT, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True
    ) as process:
        while not list(tmp_path.glob(".out.mp4.part-*/out.mp4")):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(number)
        message = process.stderr.read().strip()
        code = process.wait(120)
    assert (code, message) == (130, f"pjpdaf-bench: interrupted: {tmp_path}/out.mp4 is not written")
    assert list(tmp_path.iterdir()) == []
