"""The command `stress`: searches that are short, killed, and started again."""

import json
import os
import pty
import re
import shlex
import shutil
import signal
from contextlib import suppress
from pathlib import Path

import pytest
from commands import ROOT, assert_one_line, in_this_process, started, wait_until

from scenarios.execute.journal import FILE
from scenarios.play.job import System
from scenarios.stress.case_file import corpus_case, load_case, write_case
from scenarios.stress.replay import case_from_settings

# Six frames show nothing of a motion, but everything of the command.
WORDS = ("stress", "cross", "search", "--preset", "thesis", "--set", "frames=6", "--confirm", "0")


def test_a_search_ends_with_its_files_and_goes_on_after_a_kill(tmp_path, monkeypatch):
    """Killed with -9 in the middle; 2 workers then give the bytes that 1 gives in one go."""
    monkeypatch.chdir(tmp_path)
    words = (*WORDS, "--budget", "12", "--find", "lost")
    killed = started(*words, "--jobs", "1", "--out", "killed", cwd=tmp_path)
    journal = tmp_path / "killed" / FILE
    wait_until(lambda: journal.is_file() and journal.stat().st_size > 1500, killed)
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    size = journal.stat().st_size
    again = in_this_process(*words, "--jobs", "2", "--out", "killed")
    assert again.returncode == 0, again.stderr
    assert journal.stat().st_size > size
    assert "cross: 12 runs in fast" in again.stdout
    whole = in_this_process(*words, "--jobs", "1")
    # Without --out the folder is that of the command.
    (folder,) = (tmp_path / "runs").iterdir()
    assert (folder / "search.json").read_bytes() == (
        tmp_path / "killed" / "search.json"
    ).read_bytes()
    assert re.sub(r"runs/\S+?/", "killed/", whole.stdout) == again.stdout
    record = json.loads((folder / "search.json").read_text())
    assert len(record["families"][0]["points"]) == 12
    assert (folder / "stress.html").is_file()
    once_more = in_this_process(*words, "--jobs", "1")
    assert once_more.stdout == whole.stdout


def test_a_drawn_cause_is_named_with_what_varies_or_holds_it(tmp_path, monkeypatch):
    """The nominal `bounce` of a tall, bearded person with a small head: a hand is caught there.

    1 in 57 bearded people do so; where the detector changed, another --seed starts with one.
    """
    monkeypatch.chdir(tmp_path)
    words = ("stress", "bounce", "search", "--preset", "thesis", "--find", "swap", "--seed", "534")
    options = ("--budget", "38", "--confirm", "0", "--no-corpus", "--set", "frames=24")
    done = in_this_process(*words, *options, "--jobs", "1", "--out", "found")
    assert done.returncode == 0, done.stderr
    assert "drawn: stature high, head_scale low, beard yes" in done.stdout
    assert "--also beard lets a search vary them, " in done.stdout
    assert " --set beard=no holds them\n" in done.stdout
    (failure,) = json.loads(Path("found/search.json").read_text())["families"][0]["failures"]
    assert failure["cell"] == {}
    assert failure["drawn"] == {"stature": "high", "head_scale": "low", "beard": "yes"}
    assert failure["minimal"]["values"]["beard"] == "yes"
    assert "drawn beard yes (nominal no)" in Path("found/stress.html").read_text()
    assert "drawn: stature high" in load_case(Path("found/cases/bounce_swap_1.yaml")).note


def test_a_replay_gives_the_same_again_and_says_what_happens(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("stress", "drink", "replay", "--fidelity", "fast", "--set", "frames=6", "--seed", "3")
    first, again = in_this_process(*words), in_this_process(*words)
    assert first.stdout == again.stdout
    assert "drink seed 3, fast, tracker default: 6 frames at 3 a second" in first.stdout
    assert re.search(r"hands swapped +rho \+\d\.\d{3}\n", first.stdout)
    other = in_this_process(*words[:-1], "4")
    assert other.stdout.splitlines()[-1] != first.stdout.splitlines()[-1]
    filmed = in_this_process(*words, "--film", "x.mp4")
    assert_one_line(filmed, 2, "--film: the fast fidelity has no pictures")


@pytest.mark.long
def test_what_does_not_fail_is_promoted_as_fixed_only(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    case = case_from_settings("drink", {"frames": 4}, 3)
    system = System("thesis", "thesis")
    write_case(Path("c.yaml"), corpus_case("c", case, system, "lost_left", -0.5, "open"))
    refused = in_this_process("stress", "promote", "c.yaml", "--corpus", "mine")
    assert_one_line(refused, 2, "left hand lost does not fail with thesis when rendered")
    done = in_this_process("stress", "promote", "c.yaml", "--corpus", "mine", "--fixed")
    assert done.returncode == 0, done.stderr
    assert load_case(Path("mine/c.yaml")).status == "fixed"
    twice = in_this_process("stress", "promote", "c.yaml", "--corpus", "mine", "--fixed")
    assert_one_line(twice, 2, "is in the corpus already")


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (("croos", "search"), "did you mean cross?"),
        (("cross", "search", "--find", "swop"), "--find swop: unknown; did you mean swap?"),
        (("cross", "search", "--fidelity", "slow"), "--fidelity slow: must be fast or full"),
        (("cross", "search", "--budget", "0"), "--budget must be between 1 and"),
        (("cross", "search", "--range", "speed=0.5..0.2"), "speed: range is reversed"),
        (("nowhere.yaml", "replay"), "nowhere.yaml: no such file"),
        (("nowhere.yaml", "shrink"), "nowhere.yaml: no such file"),
        (("cross", "shrink"), "cross: is not a case file, such as `stress cross search` writes"),
        (("nowhere.yaml", "search"), "nowhere.yaml: no such file"),
        (("promote", "nowhere.yaml"), "nowhere.yaml: no such file"),
        (("cross", "replay", "--set", "speeed=1"), "did you mean speed?"),
    ],
)
def test_a_fault_is_one_line(words, fragment, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_one_line(in_this_process("stress", *words), 2, fragment)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_a_terminal_keeps_no_progress_bar_above_the_table(tmp_path):
    words = ("stress", "drink", "search", "--preset", "thesis", "--set", "frames=4", "--budget", 1)
    ours, theirs = pty.openpty()
    options = {"stdout": theirs, "stderr": theirs, "stdin": theirs}
    process = started(*words, "--confirm", 0, "--jobs", 1, "--out", tmp_path / "s", **options)
    os.close(theirs)
    shown = b""
    with suppress(OSError):  # the other end is closed
        while part := os.read(ours, 4096):
            shown += part
    os.close(ours)
    assert process.wait() == 0, shown
    assert b"drink: search" in shown
    # The last line of the bar is erased before the first of the figures.
    assert shown.rindex(b"\x1b[2K") < shown.index(b"drink: 1 run in fast")


@pytest.mark.long
def test_failures_of_a_clip_of_ones_own_have_a_command_in_place_of_a_case_file(tmp_path):
    shutil.copy(ROOT / "scenarios/catalog/clips/story.csv", tmp_path / "mine.csv")
    words = ("stress", "recorded", "search", "--set", f"clip={tmp_path / 'mine.csv'}", "--set")
    out = tmp_path / "s"
    tracker = ("--preset", "thesis", "--tracker", "faulty_trackers:Waits", "--find", "lost")
    budget = ("--no-corpus", "--budget", "1", "--confirm", "0", "--jobs", "1", "--out", out)
    done = in_this_process(*words, "frames=6", *tracker, *budget)
    assert done.returncode == 0, done.stderr
    assert list((out / "cases").iterdir()) == []
    (line,) = [x for x in done.stdout.splitlines() if x.startswith("replay: ")]
    again = in_this_process(*shlex.split(line)[2:])
    assert "head lost                    rho -5.667  fails" in again.stdout
    assert shlex.split(line)[1:] == shlex.split(
        json.loads((out / "failures.json").read_text())["searches"][0]["failures"][0]["command"]
    )
