"""Trials on real worker processes: results, journal, and trackers with a fault."""

from dataclasses import replace

import pytest

from reports.score.events import Event
from reports.score.robustness import Robustness
from scenarios.execute.journal import Journal
from scenarios.execute.local import local_executor
from scenarios.play.job import System
from scenarios.stress.case import Case, Trial, TrialFailure, TrialResult
from scenarios.stress.trials import TrialRunner

SHORT = Case("drink", {"speed": 0.5, "frames": 4}, 1)
THESIS = System("thesis", "thesis")


def of(tracker, fidelity="fast"):
    return Trial(SHORT, System("thesis", tracker), fidelity)


def test_results_are_written_and_read_back_whole():
    result = TrialResult(
        "k",
        Robustness(-0.5, 1.0, 0.25, (1.0, 0.1, -0.2), (0.1, 1.0, 1.0), (7, -1, -1, -1, -1, 9)),
        (Event("swap", 1, 2, 5, 9, True, 1.5, 2.0),),
        20,
        3.0,
        blame={("swap", 1, 5): "association"},
        occluded_frames=(0, 3, 1),
    )
    assert TrialResult.from_json(result.to_json()) == result
    assert result.severity == 5 / 20
    failure = TrialResult("k", None, failure=TrialFailure("time limit", "late"))
    assert TrialResult.from_json(failure.to_json()) == failure


def test_keys_are_of_all_that_decides_the_result():
    trial = Trial(SHORT, THESIS, "fast")
    others = [
        replace(trial, fidelity="full"),
        replace(trial, system=System("thesis", "default")),
        replace(trial, system=replace(THESIS, tracker_settings={"gate": "4"})),
        replace(trial, case=SHORT.with_seed(2)),
        replace(trial, case=SHORT.with_values({"speed": 0.6})),
    ]
    assert len({t.key for t in (trial, *others)}) == 6
    again = Case.from_json(SHORT.to_json())
    assert Trial(again, THESIS, "fast").key == trial.key


def test_a_faulty_tracker_is_quarantined_and_the_rest_goes_on(tmp_path):
    """Also: the order is that of the trials, and what the journal has is not played again."""
    trials = [of("faulty_trackers:Raises"), of("thesis", "full")]
    with Journal.open(tmp_path / "run", "w") as journal, local_executor(1) as executor:
        raised, good = TrialRunner(executor, journal).run(trials)
        assert raised.failure.kind == "plug-in"
        assert "no step today" in raised.failure.reason
        assert (good.failure, good.frames, good.key) == (None, 4, trials[1].key)
        assert good.cpu_s > 0
    with Journal.open(tmp_path / "run", "w") as journal:

        class Never:
            def outcomes(self, function, tasks, limit_s, attempts=3):
                assert not tasks
                return iter(())

        again = TrialRunner(Never(), journal).run([trials[1], trials[0]])
    assert again == [replace(good, cpu_s=0.0), replace(raised, cpu_s=0.0)]


@pytest.mark.long
def test_a_tracker_that_hangs_or_kills_its_worker_is_ended(tmp_path):
    with Journal.open(tmp_path / "run", "w") as journal, local_executor(1) as executor:
        trials = [of("faulty_trackers:Hangs"), of("faulty_trackers:Dies")]
        hung, died = TrialRunner(executor, journal, 5.0).run(trials)
    assert hung.failure == TrialFailure("time limit", "not finished within 5 s")
    assert died.failure == TrialFailure("worker died", "its worker died 3 times (exit code 7)")
