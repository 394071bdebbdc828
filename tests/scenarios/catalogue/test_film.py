"""`scenarios show --film` and the pictures of `scenarios list`, as users start them."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from pjpdaf.errors import BenchError
from reports.pictures.truth_overlay import STRIP_PX
from scenarios.catalogue import pages as gallery
from scenarios.catalogue.film import difficulty, frame_range, spread, truths
from scenarios.catalogue.list_text import WIDTH, lines
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario, scenario_names, suite_names
from sim.sequence import Simulation
from sim.truth import Truth, ViewTruth

ROOT = Path(__file__).parents[3]
COMMAND = (sys.executable, "-m", "scenarios")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def bench(*words, **options):
    return subprocess.run(
        [*COMMAND, *map(str, words)],
        cwd=options.pop("cwd", ROOT),
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def truth(index, events=(), merged=0, visible=1000):
    """A made-up truth: the first `merged` pairs are merged, in both views."""
    pairs = np.zeros((3, 3), bool)
    for a, b in ((1, 2), (0, 1), (0, 2))[:merged]:
        pairs[a, b] = pairs[b, a] = True
    view = ViewTruth(
        np.zeros((3, 2)), np.array([1000, visible, 1000]), [1000] * 3, np.zeros((3, 4)), pairs
    )
    zero = np.zeros((3, 3))
    return Truth(index, index / 3, zero, zero, zero, (view, view), tuple(events))


@pytest.mark.parametrize(
    ("words", "first", "last"),
    [(None, 0, 47), ("10:30", 10, 30), (":5", 0, 5), ("40:", 40, 47), ("7:7", 7, 7)],
)
def test_frames_are_given_by_the_first_and_the_last(words, first, last):
    assert list(frame_range(words, 48)) == list(range(first, last + 1))


@pytest.mark.parametrize("words", ["5", "a:b", "5:3", "-3:5", "0:48", "", "1:2:3"])
def test_odd_frames_are_one_line(words):
    with pytest.raises(BenchError, match="--frames"):
        frame_range(words, 48)


@pytest.mark.parametrize("seed", range(5))
def test_the_frames_of_a_sheet_are_spread_and_miss_no_merge(seed):
    rng = np.random.default_rng(seed)
    starts = rng.integers(5, 25, 3) + np.array([0, 30, 60])
    inside = {i for start in starts for i in range(start, start + 4)}
    seen = [truth(i, merged=int(i in inside)) for i in range(100)]
    chosen = spread(seen, 12)
    assert len(chosen) == 12
    assert chosen == sorted(set(chosen))
    assert chosen[0] == 0
    assert all(set(range(start, start + 4)) & set(chosen) for start in starts)
    assert np.diff([*chosen, 100]).max() < 30


def test_few_frames_are_all_on_the_sheet_and_many_events_leave_the_hard_ones():
    assert spread([truth(i) for i in range(5)], 12) == [0, 1, 2, 3, 4]
    seen = [truth(i, events=(f"step:{i}",), merged=int(i in (50, 70))) for i in range(100)]
    assert {50, 70} <= set(spread(seen, 12))


def test_the_telling_frame_is_in_the_middle_of_the_hardest_stretch():
    seen = [truth(i, events=("reach",) * (5 <= i < 30)) for i in range(40)]
    assert gallery.telling(seen).index == 17
    seen[8:11] = [truth(i, merged=1) for i in range(8, 11)]
    seen[20:25] = [truth(i, merged=1) for i in range(20, 25)]
    assert gallery.telling(seen).index == 22
    seen[33] = truth(33, merged=1, visible=0)
    assert gallery.telling(seen).index == 33
    assert gallery.telling([truth(i) for i in range(9)]).index == 4


def test_captions_say_what_is_merged_and_what_is_not_seen():
    assert gallery.caption(truth(6, ("reach", "merge:a+b:left_view"), merged=1)) == (
        "frame 6 (2.0 s), reach, R+L merged in both views"
    )
    assert gallery.caption(truth(0, visible=0)) == "frame 0 (0.0 s), R unseen in both views"


def test_truths_without_pictures_are_those_of_the_simulation():
    performance = perform(load_scenario("cross"), 100)
    quick = list(truths(performance, (0, 14)))
    with Simulation(performance) as simulation:
        for found in quick:
            full = simulation.render(found.index).truth
            np.testing.assert_array_equal(found.centres_m, full.centres_m)
            assert found.events == full.events
            for a, b in zip(found.views, full.views, strict=True):
                np.testing.assert_array_equal(a.visible_px, b.visible_px)
                np.testing.assert_array_equal(a.merged, b.merged)
    assert difficulty(quick[0]) == 0
    assert not [name for name in quick[1].script_events if "merge" in name]


def test_a_film_has_every_frame_with_its_truth(tmp_path):
    pytest.importorskip("av")
    film = tmp_path / "my.cross.mp4"
    done = bench("scenarios", "show", "cross", "--seed", 100, "--frames", "12:16", "--film", film)
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
    again = bench("scenarios", "show", "cross", "--film", film)
    assert again.returncode == 2
    assert "exists; give another name" in again.stderr


def test_a_sheet_has_frames_of_the_whole_and_takes_settings(tmp_path):
    sheet = tmp_path / "sheet.PNG"
    words = ("scenarios", "show", "drink", "--set", "frames=6", "--seed", 100, "--film", sheet)
    done = bench(*words)
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


def in_this_process(words, patch):
    """Exit code of the command; a start of its own takes a second."""
    from scenarios.cli.main import main

    patch.setattr(sys, "argv", ["pjpdaf-bench", "scenarios", *map(str, words)])
    with pytest.raises(SystemExit) as stopped:
        main()
    return stopped.value.code


@pytest.mark.parametrize(("words", "fragments"), FAULTS, ids=[" ".join(w) for w, _ in FAULTS])
def test_a_fault_is_one_line_and_nothing_is_left(words, fragments, tmp_path, monkeypatch, capsys):
    (tmp_path / "taken.png").write_text("mine")
    (tmp_path / "folder.png").mkdir()
    monkeypatch.chdir(tmp_path)
    assert in_this_process(("show", *words), monkeypatch) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    for fragment in fragments:
        assert fragment in line, line
    assert sorted(f.name for f in tmp_path.rglob("*")) == ["folder.png", "taken.png"]
    assert (tmp_path / "taken.png").read_text() == "mine"


def test_without_the_extra_a_film_is_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "av", None)
    words = ("show", "cross", "--film", tmp_path / "out.mp4")
    assert in_this_process(words, monkeypatch) == 5
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "pjpdaf-bench[video]" in line
    assert list(tmp_path.iterdir()) == []


def can_mount():
    if shutil.which("unshare") is None:
        return False
    words = ["unshare", "-Urm", "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(words, capture_output=True, check=False).returncode == 0


@pytest.mark.skipif(not can_mount(), reason="a small disk cannot be mounted here")
def test_a_full_disk_is_one_line_and_exit_code_5(tmp_path):
    pytest.importorskip("av")
    show = f'{" ".join(COMMAND)} scenarios show cross --frames 0:5 --film "$0/out.mp4"'
    script = f'mount -t tmpfs -o size=64k none "$0" && {{ {show}; echo "rc $?"; ls -A "$0"; }}'
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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_film_leaves_nothing(tmp_path, number):
    pytest.importorskip("av")
    command = [*COMMAND, "scenarios", "show", "calm_table", "--film", str(tmp_path / "out.mp4")]
    with subprocess.Popen(
        command, cwd=ROOT, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True
    ) as process:
        deadline = time.monotonic() + 60
        while not list(tmp_path.glob(".out.mp4.part-*/out.mp4")) and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(number)
        said = process.stderr.read().strip()
        code = process.wait(60)
    assert (code, said) == (130, f"pjpdaf-bench: interrupted: {tmp_path}/out.mp4 is not written")
    assert list(tmp_path.iterdir()) == []


def test_the_list_is_aligned_fits_and_names_everything():
    found = list(lines())
    assert max(map(len, found)) <= WIDTH == 100
    rows = [line for line in found if not line.startswith(" ")]
    assert [row.split()[0] for row in rows] == ["name", *scenario_names(), *suite_names()]
    places = [rows[0].index(word) for word in ("group", "frames", "T ", "what")]
    for row in rows[1:]:
        assert all(row[place - 2 : place] == "  " for place in places if len(row) > place), row
    calm, cross = (next(r for r in rows if r.startswith(name)) for name in ("calm_", "cross"))
    assert calm[places[2]] == "T"
    assert cross[places[2]] == " "
    assert calm[places[1] :].startswith("150 x 3 ")
    assert all(line[places[3]] != " " for line in found)


def test_pictures_of_scenarios_are_drawn_in_worker_processes():
    frames = {"cross": 18, "bounce": 18}  # until they are merged
    scenarios = [load_scenario(n).model_copy(update={"frames": f}) for n, f in frames.items()]
    for picture in gallery.draw_all(scenarios, workers=2):
        assert picture.large.shape == (gallery.PAGE_PX, 2 * gallery.PAGE_PX + 4, 3)
        assert picture.small.shape == (gallery.MARKDOWN_PX, 2 * gallery.MARKDOWN_PX + 4, 3)
        assert "R+L merged" in picture.caption
        assert picture.caption.startswith("frame ")


def test_only_pages_of_ours_are_replaced(tmp_path, monkeypatch, capsys):
    readme = tmp_path / "README.md"
    readme.write_text("mine")
    assert in_this_process(("list", "--markdown", readme), monkeypatch) == 2
    assert "is no catalogue page" in capsys.readouterr().err
    assert readme.read_text() == "mine"
    readme.write_text(f"<!-- {gallery.MARK} -->\n")
    gallery.check_ours(readme)
    gallery.check_ours(tmp_path / "new.html")


@pytest.mark.long
def test_the_whole_catalogue_is_drawn(tmp_path):
    page, text = tmp_path / "all.html", tmp_path / "docs/all.md"
    text.parent.mkdir()
    done = bench("scenarios", "list", "--html", page, "--markdown", text, "--jobs", 4)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"catalogue: {page}\ncatalogue: {text}\n"
    pictures = sorted((tmp_path / "docs/pictures/all").iterdir())
    assert [file.stem for file in pictures] == list(scenario_names())
    assert max(file.stat().st_size for file in pictures) <= 12_000
    for name in scenario_names():
        assert f'id="scenario-{name}"' in page.read_text()
        assert f"](pictures/all/{name}.jpg)" in text.read_text()
    assert sorted(f.name for f in tmp_path.iterdir()) == ["all.html", "docs"]


def to_nobody(*words):
    """The command with a standard output that nobody reads."""
    with subprocess.Popen(
        [*COMMAND, *map(str, words)],
        cwd=ROOT,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        process.stdout.close()
        return process.stderr.read().strip(), process.wait(60)


@pytest.mark.parametrize("words", [("list",), ("show", "cross")])
def test_a_reader_that_goes_away_is_no_fault(words):
    assert to_nobody("scenarios", *words) == ("", 0)


def test_a_run_is_saved_though_nobody_reads_its_table(tmp_path):
    out = tmp_path / "run"
    said, code = to_nobody("run", "cross", "--seeds", 1, "--set", "frames=2", "--out", out)
    assert (said, code) == ("", 0)
    assert {"run.json", "report.html", "frames.parquet"} <= {f.name for f in out.iterdir()}


def test_exit_codes_stay_though_nobody_reads():
    _, code = to_nobody("run", "crss")
    assert code == 2
