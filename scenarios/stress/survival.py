"""How often a case fails with fresh noise: counted, or decided by as few episodes as will do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice

from scenarios.stress.case import Case
from scenarios.stress.search.evaluation import Evaluation

_TOGETHER = 2  # episodes: a form that is cured shows it by two passes

Evaluate = Callable[[Sequence[Case]], list[Evaluation]]


@dataclass(frozen=True)
class Survival:
    """In how many of `of` episodes with fresh noise a case fails; severity: mean over those."""

    failed: int
    of: int
    severity: float = 0.0

    @property
    def text(self) -> str:
        """As "7/8"."""
        return f"{self.failed}/{self.of}"

    @property
    def share(self) -> float:
        """Share of the episodes that fail, 0 of none."""
        return self.failed / self.of if self.of else 0.0


@dataclass(frozen=True)
class Rule:
    """When a sequential test ends: with `first` failures, `more` further ones for each pass, the
    case fails; with more than `passes` passes it does not.
    """

    first: int
    more: int
    passes: int

    def next_batch(self, failed: int, passed: int) -> int:
        """Episodes until it can be decided at the earliest; 0: decided."""
        if passed > self.passes:
            return 0
        return max(0, self.first + self.more * passed - failed)


# Of a form that fails 19 times in 20 it accepts 93 %, of one that fails 7 times in 10, 23 %; a form
# that is cured is dropped after two or three episodes.
STRICT = Rule(first=5, more=4, passes=1)
# Where the case itself fails less often than 7 times in 8. Of 3 in 4 it accepts a half, of a half
# 9 %.
LENIENT = Rule(first=4, more=3, passes=2)


@dataclass
class Oracle:
    """Whether forms of a case fail with fresh noise, and how they did so far.

    noise: seeds, each used once: seeds that chose one form flatter the next; most: episodes in all,
    after which nothing counts as failing; seen: of every form that failed, its failing evaluations.
    """

    evaluate: Evaluate
    measure: str
    noise: Iterator[int]
    most: int
    runs: int = 0
    seen: dict[str, tuple[Case, list[Evaluation]]] = field(default_factory=dict)

    def fails(self, case: Case, rule: Rule, kept_back: int = 0) -> bool:
        """Whether the case fails by the rule; not, where that would take the last `kept_back`."""
        failed: list[Evaluation] = []
        played = 0
        while batch := rule.next_batch(len(failed), played - len(failed)):
            if self.runs + batch > self.most - kept_back:
                return False
            failed += self.play(case, min(batch, _TOGETHER))
            played += min(batch, _TOGETHER)
        accepted = played - len(failed) <= rule.passes
        if accepted:
            self.seen[case.with_seed(0).digest] = case, failed
        return accepted

    def survival(self, case: Case, count: int, passes: int) -> tuple[Survival, list[Evaluation]]:
        """Its survival in up to `count` episodes, ended by more passes than `passes`.

        With fewer episodes where not so many are left. Also the evaluations that failed.
        """
        failed: list[Evaluation] = []
        played = 0
        while played < count and played - len(failed) <= passes:
            batch = min(_TOGETHER, count - played, self.most - self.runs)
            if batch <= 0:
                break
            failed += self.play(case, batch)
            played += batch
        return Survival(len(failed), played, mean_severity(failed)), failed

    def play(self, case: Case, count: int) -> list[Evaluation]:
        """The evaluations, of `count` with fresh noise, that fail with the measure."""
        evaluations = self.evaluate([case.with_seed(n) for n in islice(self.noise, count)])
        self.runs += count
        return [e for e in evaluations if self.measure in e.result.failed]


def survival_of(case: Case, measure: str, evaluate: Evaluate, seeds: Sequence[int]) -> Survival:
    """In how many episodes, one of each noise seed, the case fails with the measure."""
    evaluations = evaluate([case.with_seed(seed) for seed in seeds])
    failed = [e for e in evaluations if measure in e.result.failed]
    return Survival(len(failed), len(seeds), mean_severity(failed))


def mean_severity(failed: Sequence[Evaluation]) -> float:
    """Mean severity of evaluations, 0 of none."""
    return sum(e.result.severity for e in failed) / len(failed) if failed else 0.0
