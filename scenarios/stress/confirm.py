"""Confirmation: a failure of the fast fidelity counts once the rendered episode fails too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from reports.score.robustness import GOALS, measures_of
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.search.distinct import DistinctFailure
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.survival import Survival, survival_of
from sim.randomness import generator

SEEDS = 4  # fresh noise seeds by which the case to render is chosen
MOST_RUNS = 2 * SEEDS  # of a choice: the case as it came up, and its minimal form

Evaluate = Callable[[Sequence[Case]], list[Evaluation]]


@dataclass(frozen=True)
class Counterexample:
    """A distinct failure and what became of it in full.

    case: the one that was rendered, the found or the minimal one, whichever fails oftener with
    fresh noise (survival, in the fidelity of the search); full: its result, None where it was not
    rendered; runs: trials of the choice.
    """

    failure: DistinctFailure
    case: Case
    survival: Survival
    full: Evaluation | None = None
    runs: int = 0

    @property
    def measure(self) -> str:
        """The measure that fails."""
        return self.failure.signature.measure

    @property
    def confirmed(self) -> bool:
        """Whether the rendered episode fails with a measure of the same kind."""
        if self.full is None:
            return False
        goal = next(goal for goal in GOALS if self.measure in measures_of((goal,)))
        return bool(self.full.failures((goal,)))

    @property
    def counts(self) -> bool:
        """Whether it is a failure: confirmed, or not rendered."""
        if self.result.robustness is None:
            return False
        return self.full is None or self.confirmed

    @property
    def result(self) -> TrialResult:
        """The result that counts: of the rendered episode where there is one."""
        played = self.full is not None and self.full.result.robustness is not None
        return self.full.result if self.full and played else self.failure.evaluation.result

    @property
    def blame(self) -> str:
        """The stages at fault for the events of the rendered episode, in order, each once."""
        return ", ".join(dict.fromkeys(self.result.blame.values()))


def choose(
    failure: DistinctFailure,
    evaluate: Evaluate,
    seed: int,
    number: int = 0,
    most: int = MOST_RUNS,
) -> Counterexample:
    """The case of a failure that is most likely to fail again, by up to `SEEDS` fresh noise seeds.

    number: of the failure, whose noise is its own; most: trials that it may take.
    """
    rng = generator(seed, "stress/confirm/noise", number)
    noise = [int(n) for n in rng.integers(2**31, size=SEEDS)]
    measure = failure.signature.measure
    same = failure.minimal == failure.evaluation.case
    cases = (failure.evaluation.case,) if same else (failure.evaluation.case, failure.minimal)
    noise = noise[: most // len(cases)]
    tried = [(survival_of(case, measure, evaluate, noise), case) for case in cases]
    survival, case = max(tried, key=lambda pair: pair[0].failed)
    return Counterexample(failure, case, survival, runs=len(noise) * len(cases))


def confirm(
    found: Sequence[Counterexample], evaluate_full: Evaluate, most: int
) -> list[Counterexample]:
    """Render the cases, those that survive oftenest first, at most `most`; the order stays."""
    order = sorted(range(len(found)), key=lambda n: (-found[n].survival.failed, n))[:most]
    results = evaluate_full([found[n].case for n in order])
    full = dict(zip(order, results, strict=True))
    return [replace(one, full=full.get(n)) for n, one in enumerate(found)]
