"""An evaluated point of a search, and the systems that it is evaluated with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from reports.score.robustness import MEASURES, Goal, measures_of
from scenarios.play.job import System
from scenarios.stress.case import Case, Fidelity, Trial, TrialResult
from scenarios.stress.trials import TrialRunner

NO_RESULT = 3.0  # objective of a trial without a result: above any that has one


@dataclass(frozen=True)
class Evaluation:
    """A case with its result; other: that of the system to compare with, where there is one."""

    case: Case
    result: TrialResult
    other: TrialResult | None = None

    def failures(self, goals: Sequence[Goal]) -> tuple[str, ...]:
        """The measures below 0 of these goals that count: not below 0 with the other system."""
        failed = [name for name in self.result.failed if name in measures_of(goals)]
        if self.other is None:
            return tuple(failed)
        if self.other.robustness is None:
            return ()  # without a result of the other, nothing is shown
        return tuple(name for name in failed if name not in self.other.failed)

    def primary(self, goals: Sequence[Goal]) -> str:
        """The failure that comes first, which the others follow from; "" without any."""
        failed = self.failures(goals)
        robustness = self.result.robustness
        if robustness is None or not failed:
            return ""
        ends = dict(zip(MEASURES, robustness.ends, strict=True))
        return min(failed, key=lambda name: ends[name])

    def objective(self, goal: Goal) -> float:
        """J of the goal; `NO_RESULT` where there is none, or where the other system fails too."""
        if self.result.robustness is None:
            return NO_RESULT
        value = self.result.robustness.objective(goal)
        if value < 0 and self.other is not None and not self.failures((goal,)):
            return NO_RESULT
        return value


@dataclass(frozen=True)
class Evaluator:
    """Evaluates cases: of a system, and of another one where that fails."""

    runner: TrialRunner
    system: System
    fidelity: Fidelity
    against: System | None = None

    def evaluate(self, cases: Sequence[Case]) -> list[Evaluation]:
        """The evaluations of cases, in order. Raises as `TrialRunner.run`."""
        trials = [Trial(case, self.system, self.fidelity) for case in cases]
        results = self.runner.run(trials)
        if self.against is None:
            return [Evaluation(c, r) for c, r in zip(cases, results, strict=True)]
        failing = [n for n, result in enumerate(results) if result.failed]
        again = [Trial(cases[n], self.against, self.fidelity) for n in failing]
        others = dict(zip(failing, self.runner.run(again), strict=True))
        return [
            Evaluation(case, result, others.get(n))
            for n, (case, result) in enumerate(zip(cases, results, strict=True))
        ]
