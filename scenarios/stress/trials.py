"""Many trials: played by an executor, each kept in a journal as soon as it is finished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from scenarios.execute.executor import Executor
from scenarios.execute.journal import Journal
from scenarios.stress.case import Trial, TrialFailure, TrialResult
from scenarios.stress.play_trial import play_trial
from sim.processes import Lost

TIME_LIMIT_S = 900.0  # of one trial


@dataclass(frozen=True)
class TrialRunner:
    """Plays trials. What the journal has is not played again.

    time_limit_s: of one trial; on_result: called for each trial that is played or found in the
    journal, with its result; interrupted: whether to end.
    """

    executor: Executor
    journal: Journal
    time_limit_s: float = TIME_LIMIT_S
    on_result: Callable[[Trial, TrialResult], None] = lambda trial, result: None
    interrupted: Callable[[], bool] = lambda: False

    def run(self, trials: Sequence[Trial]) -> list[TrialResult]:
        """The results of trials, in their order, whatever the number of workers.

        A tracker that raises, hangs or kills its worker gives a result with a failure. Raises
        InfrastructureError of OpenGL, and of a disk that is full; KeyboardInterrupt: all that is
        finished is in the journal.
        """
        results: dict[str, TrialResult] = {}
        waiting: dict[str, Trial] = {}
        for trial in trials:
            self._end_if_interrupted()
            kept = self._kept(trial.key)
            if kept is not None:
                results[trial.key] = kept
                self.on_result(trial, kept)
            else:
                waiting.setdefault(trial.key, trial)
        tasks = dict(enumerate(waiting.values()))
        for indexed in self.executor.outcomes(play_trial, tasks, self.time_limit_s):
            self._end_if_interrupted()
            if indexed is None:
                continue
            trial, outcome = tasks[indexed[0]], indexed[1]
            if isinstance(outcome, Lost):
                result = TrialResult(trial.key, None, failure=self._loss(outcome))
            elif isinstance(outcome.value, TrialResult):
                result = outcome.value
            else:
                raise outcome.value
            self.journal.append(trial.key, result.to_json())
            results[trial.key] = result
            self.on_result(trial, result)
        return [results[trial.key] for trial in trials]

    def _end_if_interrupted(self) -> None:
        # A KeyboardInterrupt that is raised while pydantic writes a digest does not come out of it.
        if self.interrupted():
            raise KeyboardInterrupt

    def _kept(self, key: str) -> TrialResult | None:
        """The result in the journal, None where there is none, or none that can be read."""
        payload = self.journal.finished.get(key)
        if payload is None:
            return None
        try:
            return TrialResult.from_json(payload)
        except (ValueError, KeyError, TypeError):
            return None

    def _loss(self, lost: Lost) -> TrialFailure:
        if lost.late:
            return TrialFailure("time limit", f"not finished within {self.time_limit_s:g} s")
        return TrialFailure("worker died", lost.death)
