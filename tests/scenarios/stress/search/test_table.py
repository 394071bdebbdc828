"""The table of failures in the terminal: what was not tried, and what gave no result."""

from made_failures import evaluated, found

from scenarios.stress.case import Case, TrialFailure, TrialResult
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.search.table import failure_table

CASE = Case("cross", {"speed": 0.5}, 3)


def test_a_rendered_run_without_a_result_has_not_passed():
    lost = Evaluation(CASE, TrialResult("k", None, failure=TrialFailure("plug-in", "no step")))
    shown = [
        found(CASE, survived=0),
        found(CASE, evaluated(CASE, -0.1)),
        found(CASE, evaluated(CASE, 0.1)),
        found(CASE, lost),
    ]
    columns = {str(c.header).split()[-1]: list(c.cells) for c in failure_table("x", shown).columns}
    assert columns["full"] == ["-", "fails", "passes", "none"]
    assert columns["again"] == ["-", "4/4", "4/4", "4/4"]
