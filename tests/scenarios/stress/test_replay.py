"""Replays of plug-ins that misbehave, and what the corpus does not take."""

import pytest
from commands import assert_one_line, bench, in_this_process

from scenarios.play.job import System
from scenarios.stress.case_file import corpus_case, write_case
from scenarios.stress.replay import case_from_settings

SHORT = ("stress", "drink", "replay", "--fidelity", "fast", "--set", "frames=4")


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (("faulty_trackers:Dies",), "drink seed 0: no result: its worker died once (exit code 7)"),
        (("faulty_trackers:Hangs", "--time-limit", "1"), "no result: not finished within 1 s"),
        (("faulty_trackers:Raises",), "no result: frame 1: tracker 'faulty_trackers:Raises': step"),
    ],
    ids=["dies", "hangs", "raises"],
)
def test_a_replay_without_a_result_is_one_line(words, fragment):
    assert_one_line(in_this_process(*SHORT, "--tracker", *words), 5, fragment)


@pytest.mark.long
def test_what_a_tracker_prints_is_not_among_the_figures(tmp_path):
    words = (*SHORT, "--preset", "thesis", "--tracker", "faulty_trackers:Prints")
    done = bench(*words, PYTHONPATH="tests:.")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("a step") == 3
    assert "a step" not in done.stdout
    assert "drink seed 0, fast, tracker faulty_trackers:Prints" in done.stdout


@pytest.fixture
def case(tmp_path):
    """A case file that names code."""
    drink = case_from_settings("drink", {"frames": 4}, 3)
    system = System("thesis", "faulty_trackers:Waits")
    write_case(tmp_path / "c.yaml", corpus_case("c", drink, system, "lost_left", -0.5, "open"))
    return tmp_path / "c.yaml"


@pytest.mark.parametrize("verb", [("replay",), ("shrink",), ("promote",)])
def test_a_case_file_alone_starts_no_code(verb, case):
    done = in_this_process("stress", case, *verb)
    tracker = "--tracker faulty_trackers:Waits"
    assert_one_line(done, 2, f"c.yaml: names the tracker {tracker[10:]}; give {tracker} too")


def test_a_case_is_played_with_the_tracker_that_the_user_names(case):
    words = ("stress", case, "replay", "--fidelity", "fast", "--tracker")
    own = in_this_process(*words, "faulty_trackers:Waits").stdout
    assert "left hand lost: fails as the file says" in own
    assert "left hand lost: does not fail any more" in in_this_process(*words, "thesis").stdout


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (("--name", "../x"), "--name ../x: must be lower-case letters, digits and _"),
        (("--corpus", "file"), "file: is a file; a corpus is a folder"),
    ],
)
def test_a_case_that_is_not_put_in_is_not_played(words, fragment, case, monkeypatch):
    monkeypatch.chdir(case.parent)
    (case.parent / "file").write_text("mine")
    done = in_this_process("stress", "promote", "c.yaml", "--tracker", "thesis", *words)
    assert_one_line(done, 2, fragment)
