"""Evaluations by real trackers: one that never gives an estimate, against one that does."""

import pytest

from scenarios.execute.journal import Journal
from scenarios.play.job import System
from scenarios.stress.replay import case_from_settings
from scenarios.stress.search.evaluation import NO_RESULT, Evaluator
from scenarios.stress.trials import TrialRunner
from sim.processes import Answer

WAITS = System("thesis", "faulty_trackers:Waits")
THESIS = System("thesis", "thesis")
CASE = case_from_settings("cross", {"frames": 6}, 1)
LOSSES = ("lost_head", "lost_right", "lost_left")


class Here:
    """An executor in this process."""

    def outcomes(self, function, tasks, limit_s, attempts=3):
        for index, task in tasks.items():
            yield index, Answer(function(task))


@pytest.fixture
def runner(tmp_path):
    with Journal.open(tmp_path / "j", "x") as journal:
        yield TrialRunner(Here(), journal)


def test_a_tracker_that_gives_nothing_loses_all(runner):
    (evaluation,) = Evaluator(runner, WAITS, "fast").evaluate([CASE])
    assert evaluation.failures(("lost",)) == LOSSES
    assert evaluation.primary(("lost",)) == "lost_head"
    assert evaluation.failures(("swap",)) == ()


def test_only_what_the_other_tracker_does_not_fail_counts(runner):
    (better,) = Evaluator(runner, WAITS, "fast", against=THESIS).evaluate([CASE])
    (same,) = Evaluator(runner, WAITS, "fast", against=WAITS).evaluate([CASE])
    (passes,) = Evaluator(runner, THESIS, "fast", against=WAITS).evaluate([CASE])
    assert better.failures(("lost",)) == LOSSES
    assert better.objective("lost") == -1.0
    assert same.failures(("lost",)) == ()
    assert same.objective("lost") == NO_RESULT
    assert passes.failures(("lost",)) == ()
    assert passes.other is None  # not played: there is nothing to compare
