"""The search of a family: known cases and corners, Sobol points, CMA-ES from the best of them.

Points are evaluated in generations of fixed size and decided upon between them, so that the result
is the same for any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from cmaes import CMA

from pjpdaf.arrays import Floats
from reports.score.robustness import GOALS, Goal
from scenarios.stress.case import Case
from scenarios.stress.search.design import corners, sobol
from scenarios.stress.search.distinct import DistinctFailure, attribute, explained
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.space import Space
from sim.randomness import generator

GENERATION = 16
SOBOL_BLOCK = 16  # between two rounds of descents
SIGMA = 0.2  # of the unit cube, at the start of a descent
LONGEST_DESCENT = 12  # generations
STALLED = 4  # generations without a better point end a descent
ENOUGH = 6  # failures end a descent: what else is there lies elsewhere
NEAR = 0.15  # of the unit cube, root mean square over the axes: no second descent from there

Evaluate = Callable[[Sequence[Case]], list[Evaluation]]


@dataclass(frozen=True)
class SearchPlan:
    """How to search. budget: trials, points and what narrows failures down; goals: the failures
    that count, in turn; seed: of it all.

    known: cases to begin with; distinct: enough distinct failures; patience: trials without a new
    one, after which it ends; fresh: trials of the budget that are kept back for each distinct
    failure, for `scenarios.stress.confirm.choose`.
    """

    budget: int = 500
    goals: tuple[Goal, ...] = GOALS
    seed: int = 0
    known: tuple[Case, ...] = ()
    distinct: int = 20
    patience: int = 2000
    fresh: int = 0


@dataclass(frozen=True)
class FamilySearch:
    """The result of a search. evaluations: of all points, in order; runs: trials in all, those
    that narrow failures down among them.

    ended: why it ended: "budget", "distinct" or "patience".
    """

    space: Space
    evaluations: tuple[Evaluation, ...]
    failures: tuple[DistinctFailure, ...]
    runs: int
    ended: str

    def first_failure(self, goals: Sequence[Goal] = GOALS) -> int | None:
        """How many points were evaluated up to the first failure; None without any."""
        for number, evaluation in enumerate(self.evaluations, start=1):
            if evaluation.failures(goals):
                return number
        return None


def search_family(space: Space, evaluate: Evaluate, plan: SearchPlan) -> FamilySearch:
    """Search a family for distinct failures. Raises what `evaluate` raises."""
    state = _Search(space, evaluate, plan)
    name, d = space.family.name, len(space.axes)
    state.play([case for case in plan.known if case.family == name])
    state.play_points([space.unit_of_values(space.nominal()), *corners(d)[1:]])
    points = sobol(d, plan.seed, f"stress/{name}")
    while not state.ended:
        for _ in range(SOBOL_BLOCK // GENERATION):
            state.play_points(list(islice(points, GENERATION)))
        for goal in plan.goals if d else ():  # else only the noise varies
            start = state.start_of(goal)
            if start is not None:
                _descend(state, goal, start)
    return FamilySearch(
        space, tuple(state.evaluations), tuple(state.failures), state.runs, state.ended
    )


def _descend(state: _Search, goal: Goal, start: Floats) -> None:
    """Follow the objective of a goal down from a point, a generation at a time."""
    number = len(state.starts[goal])
    state.starts[goal].append(start)
    stream = f"stress/{state.space.family.name}/{goal}/descent"
    evolution = CMA(
        mean=np.clip(start, 0.02, 0.98),
        sigma=SIGMA,
        bounds=np.array([[0.0, 1.0]] * len(start)),
        population_size=GENERATION,
        seed=int(generator(state.plan.seed, stream, number).integers(2**31)),
    )
    best, stalled, failures = np.inf, 0, 0
    for _ in range(LONGEST_DESCENT):
        points = [evolution.ask() for _ in range(GENERATION)]
        evaluations = state.play_points(points)
        if state.ended or len(evaluations) < GENERATION:
            return
        costs = [evaluation.objective(goal) for evaluation in evaluations]
        evolution.tell(list(zip(points, costs, strict=True)))
        failures += sum(bool(evaluation.failures((goal,))) for evaluation in evaluations)
        stalled = 0 if min(costs) < best - 0.01 else stalled + 1
        best = min(best, *costs)
        if failures >= ENOUGH or stalled >= STALLED or evolution.should_stop():
            return


@dataclass
class _Search:
    """The state of a search."""

    space: Space
    evaluate: Evaluate
    plan: SearchPlan
    evaluations: list[Evaluation] = field(default_factory=list)
    failures: list[DistinctFailure] = field(default_factory=list)
    runs: int = 0
    runs_at_last: int = 0
    starts: dict[Goal, list[Floats]] = field(default_factory=lambda: {goal: [] for goal in GOALS})

    @property
    def left(self) -> int:
        """Trials that are left: of the budget, without those kept back for the failures so far."""
        return self.plan.budget - self.runs - self.plan.fresh * len(self.failures)

    @property
    def ended(self) -> str:
        if len(self.failures) >= self.plan.distinct:
            return "distinct"
        if self.left <= 0:
            return "budget"
        if self.runs - self.runs_at_last >= self.plan.patience:
            return "patience"
        return ""

    def play_points(self, points: Sequence[Floats]) -> list[Evaluation]:
        """Evaluate points of the unit cube, each with noise of its own."""
        return self.play(
            [
                Case(self.space.family.target, self.space.values_of_unit(point), self._noise(n))
                for n, point in enumerate(points, start=len(self.evaluations))
            ]
        )

    def play(self, cases: Sequence[Case]) -> list[Evaluation]:
        """Evaluate cases as far as the budget goes; new failures are attributed."""
        if self.ended:
            return []
        cases = cases[: self.left]
        evaluations = self.evaluate(cases)
        self.runs += len(cases)
        self.evaluations += evaluations
        self._attribute(evaluations)
        return evaluations

    def start_of(self, goal: Goal) -> Floats | None:
        """The best point by the goal's objective that is near no start and no failure."""
        failed = [e.case.values for e in self.evaluations if e.failures((goal,))]
        taken = [*self.starts[goal], *(self.space.unit_of_values(values) for values in failed)]
        for evaluation in sorted(self.evaluations, key=lambda e: e.objective(goal)):
            point = self.space.unit_of_values(evaluation.case.values)
            if all(np.sqrt(np.mean((point - other) ** 2)) > NEAR for other in taken):
                return point
        return None

    def _attribute(self, evaluations: Sequence[Evaluation]) -> None:
        """Of each measure that fails first, attribute the worst that no signature explains.

        With what is left of the budget: a failure among the last points is kept as it is.
        """
        worst: dict[str, Evaluation] = {}
        for evaluation in evaluations:
            measure = evaluation.primary(self.plan.goals)
            known = [failure.signature for failure in self.failures]
            if not measure or explained(known, self.space, evaluation.case, measure):
                continue
            if measure not in worst or _rho(evaluation, measure) < _rho(worst[measure], measure):
                worst[measure] = evaluation
        for measure, evaluation in worst.items():
            if len(self.failures) >= self.plan.distinct:
                return
            failure = attribute(self.space, evaluation, measure, self._failing)
            if self._is_new(failure):
                self._keep(failure)
                self.runs_at_last = self.runs

    def _keep(self, failure: DistinctFailure) -> None:
        """Keep a failure in place of those that its signature turns out to cover."""
        covers = failure.signature.covers if failure.narrowed else lambda other: False
        self.failures = [f for f in self.failures if not covers(f.signature)]
        self.failures.append(failure)

    def _is_new(self, failure: DistinctFailure) -> bool:
        """Whether it is distinct; one that was not narrowed down may be any of its measure."""
        if failure.narrowed:
            return all(failure.signature != other.signature for other in self.failures)
        measure = failure.signature.measure
        return all(measure != other.signature.measure for other in self.failures)

    def _failing(self, case: Case) -> Sequence[str] | None:
        """The measures that fail; None where no trial is left for it."""
        if self.left <= self.plan.fresh:  # of which the failure itself will need as many
            return None
        self.runs += 1
        return self.evaluate([case])[0].failures(self.plan.goals)

    def _noise(self, number: int) -> int:
        stream = f"stress/{self.space.family.name}/noise"
        return int(generator(self.plan.seed, stream, number).integers(2**31))


def _rho(evaluation: Evaluation, measure: str) -> float:
    robustness = evaluation.result.robustness
    return np.inf if robustness is None else robustness.measures[measure]
