"""What the page has of a failure: its name, and a command that plays it again."""

from pathlib import Path

import pytest
from made_failures import evaluated, found

from scenarios.play.job import System
from scenarios.spec.parameters.file import FileText
from scenarios.stress.case import Case, TrialFailure, TrialResult
from scenarios.stress.case_file import can_be_file
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.search.page_record import failure_command, failure_name, shown_failures

MINE = System("default", "mine:make")
CLIP = FileText("a clip.csv", Path("/x/a clip.csv"), "0" * 64)


@pytest.mark.parametrize(
    ("case", "command"),
    [
        (
            Case("cross", {"speed": 0.5}, 3),
            "pjpdaf-bench stress c.yaml replay --tracker mine:make",
        ),
        (
            Case("own:knock", {"speed": 0.5}, 3),
            "PJPDAF_BENCH_MOTIONS=own:knock pjpdaf-bench stress c.yaml replay --tracker mine:make",
        ),
    ],
)
def test_a_file_and_what_it_alone_does_not_start(case, command):
    assert failure_command(found(case), Path("c.yaml"), MINE, "fast") == command


def test_a_clip_of_ones_own_is_in_the_command():
    case = Case("recorded", {"slow": 2.0, "clip": CLIP}, 3)
    assert not can_be_file(case)
    words = "pjpdaf-bench stress recorded replay --seed 3 --tracker thesis"
    values = "--set slow=2.0 --set 'clip=a clip.csv'"
    thesis = System("thesis", "thesis")
    one = found(case)
    assert failure_command(one, None, thesis, "fast") == f"{words} --fidelity fast {values}"
    rendered = found(case, evaluated(case, -0.2))
    assert failure_command(rendered, None, thesis, "fast") == f"{words} {values}"


def test_only_what_counts_is_shown_and_by_its_number():
    case = Case("cross", {"speed": 0.5}, 3)
    lost = TrialResult("k", None, failure=TrialFailure("plug-in", "no step"))
    all_found = [
        found(case, evaluated(case, 0.5)),  # not in pictures
        found(case, evaluated(case, -0.1)),
        found(case),
        found(case, Evaluation(case, lost)),
    ]
    assert [one.counts for one in all_found] == [False, True, True, False]
    shown = shown_failures(all_found, MINE, "fast")
    assert {n: (s.label, s.trial.fidelity) for n, s in shown.items()} == {
        1: ("cross_swap_2", "full"),
        2: ("cross_swap_3", "fast"),
    }
    assert failure_name(all_found[2], 3) == "cross_swap_3"
