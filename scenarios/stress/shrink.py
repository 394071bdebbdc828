"""Shrink: the least that still makes a tracker fail, and the worst that was seen on the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from reports.score.robustness import MEASURES
from scenarios.stress.case import Case
from scenarios.stress.minimise import minimal_changes
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.space import Space
from sim.motion.stage import Value
from sim.randomness import generator

# A failure is one of a case's if it fails with 6 of 8 fresh noise seeds. Where the case itself
# fails with 7 or 8, so must every form: of twenty that fail half the time, three pass 6 of 8.
SEEDS, NEEDED, STRICT = 8, 6, 7
BATCHES = (3, 3, 2)  # of them, played together: most cases are decided by the first or second
BISECTIONS = 2  # of each parameter that is left, towards nominal
# The seeds by which a form was chosen flatter it: others must bear it out, else it goes back half
# of the way, at most so often.
CHECK_SEEDS, CHECK_NEEDED, MOST_BACK = 16, 13, 3
SPARE_S = 1.0  # after the last failing window, when the time is cut

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


@dataclass(frozen=True)
class Shrunk:
    """The result of shrinking a case.

    changed: its parameters that were not nominal; needed: those that the minimal case still
    changes; runs: trials for all of it, without the survival of the two at the end. minimal,
    severe: None where the case did not survive fresh noise itself.
    """

    case: Case
    measure: str
    survival: Survival
    changed: tuple[str, ...]
    runs: int
    needed: tuple[str, ...] = ()
    minimal: Case | None = None
    minimal_survival: Survival | None = None
    severe: Case | None = None
    severe_survival: Survival | None = None

    @property
    def differences(self) -> Mapping[str, Value]:
        """The values of the minimal case that are not nominal."""
        return {} if self.minimal is None else {n: self.minimal.values[n] for n in self.needed}


@dataclass
class _Oracle:
    """Whether a case fails with fresh noise; remembers what it has seen."""

    evaluate: Evaluate
    measure: str
    seeds: tuple[int, ...]
    needed: int = NEEDED
    runs: int = 0
    failing: dict[str, tuple[Case, list[Evaluation]]] = field(default_factory=dict)

    def fails(self, case: Case) -> bool:
        """Whether it fails with `needed` of the seeds, played until that is decided."""
        failed: list[Evaluation] = []
        played = 0
        for batch in BATCHES:
            seeds = self.seeds[played : played + batch]
            failed += self.play(case, seeds)
            played += batch
            if len(failed) >= self.needed:
                self.failing[case.with_seed(0).digest] = case, failed
                return True
            if played - len(failed) > SEEDS - self.needed:
                return False
        return False

    def play(self, case: Case, seeds: Sequence[int]) -> list[Evaluation]:
        """The evaluations that fail with the measure."""
        evaluations = self.evaluate([case.with_seed(seed) for seed in seeds])
        self.runs += len(seeds)
        return [e for e in evaluations if self.measure in e.result.failed]


def shrink(
    space: Space, case: Case, measure: str, evaluate: Evaluate, fresh: int = 100, seed: int = 0
) -> Shrunk:
    """Shrink a failing case: fewest changes from nominal, smallest changes, fewest frames.

    measure: the failure that must survive; fresh: episodes for the survival of the minimal and of
    the most severe case, with noise that no step has used. Raises what `evaluate` raises.
    """
    noise = [
        int(n)
        for n in generator(seed, "stress/shrink/noise").integers(
            2**31, size=SEEDS + CHECK_SEEDS + fresh
        )
    ]
    oracle = _Oracle(evaluate, measure, tuple(noise[:SEEDS]))
    nominal = space.nominal()
    case = case.with_values({n: v for n, v in nominal.items() if n not in case.values})
    changed = _by_distance(space, case, nominal)
    survival = survival_of(case, measure, evaluate, noise[:SEEDS])
    if survival.failed < NEEDED:
        return Shrunk(case, measure, survival, changed, SEEDS)
    oracle.needed = min(STRICT, survival.failed)
    oracle.fails(case)  # of trials that have just been played
    oracle.runs = SEEDS

    def with_changes(names: Sequence[str]) -> Case:
        return case.with_values({n: nominal[n] for n in changed if n not in names})

    needed = minimal_changes(changed, lambda names: oracle.fails(with_changes(names)))
    reduced = minimal = with_changes(needed)
    for name in needed:
        minimal = _bisected(space, minimal, name, nominal[name], oracle)
    check = noise[SEEDS : SEEDS + CHECK_SEEDS]
    minimal, failed = _borne_out(space, minimal, reduced, oracle, check)
    minimal = _cut(minimal, failed, oracle)
    severe = max(
        (_mean_severity(seen), -number, tried)
        for number, (tried, seen) in enumerate(oracle.failing.values())
    )[2]
    late = noise[SEEDS + CHECK_SEEDS :]
    return Shrunk(
        case,
        measure,
        survival,
        changed,
        oracle.runs,
        needed,
        minimal,
        survival_of(minimal, measure, evaluate, late),
        severe,
        survival_of(severe, measure, evaluate, late),
    )


def survival_of(case: Case, measure: str, evaluate: Evaluate, seeds: Sequence[int]) -> Survival:
    """In how many episodes, one of each noise seed, the case fails with the measure."""
    evaluations = evaluate([case.with_seed(seed) for seed in seeds])
    failed = [e for e in evaluations if measure in e.result.failed]
    return Survival(len(failed), len(seeds), _mean_severity(failed))


def _mean_severity(failed: Sequence[Evaluation]) -> float:
    return sum(e.result.severity for e in failed) / len(failed) if failed else 0.0


def _by_distance(space: Space, case: Case, nominal: Mapping[str, Value]) -> tuple[str, ...]:
    """Names of the changed parameters, those nearest to nominal first."""
    apart = abs(space.unit_of_values(case.values) - space.unit_of_values(nominal))
    distance = dict(zip(space.names, apart.tolist(), strict=True))
    changed = [name for name in space.names if case.values[name] != nominal[name]]
    return tuple(sorted(changed, key=lambda name: distance[name]))


def _bisected(space: Space, case: Case, name: str, nominal: Value, oracle: _Oracle) -> Case:
    """The case with a number as near to nominal as bisection brings it; choices stay."""
    axis = space.axis(name)
    if axis.choices:
        return case
    good, bad = axis.to_unit(case.values[name]), axis.to_unit(nominal)
    for _ in range(BISECTIONS):
        middle = (good + bad) / 2
        tried = case.with_values({name: axis.of_unit(middle)})
        if oracle.fails(tried):
            case, good = tried, middle
        else:
            bad = middle
    return case


def _borne_out(
    space: Space, case: Case, reduced: Case, oracle: _Oracle, seeds: Sequence[int]
) -> tuple[Case, list[Evaluation]]:
    """The case, or half-way back to `reduced`, until enough of other noise seeds fail.

    Also the evaluations that failed. A form at the very edge fails with the seeds that led there,
    and with half of all others.
    """
    failed: list[Evaluation] = []
    for back in range(MOST_BACK + 1):
        failed = oracle.play(case, seeds)
        if len(failed) >= CHECK_NEEDED or back == MOST_BACK or case == reduced:
            break
        last = back == MOST_BACK - 1
        case = reduced if last else _between(space, case, reduced)
    return case, failed


def _between(space: Space, case: Case, other: Case) -> Case:
    """The case whose numbers lie half-way between those of two."""
    middle = (space.unit_of_values(case.values) + space.unit_of_values(other.values)) / 2
    values = space.values_of_unit(middle)
    return case.with_values({n: v for n, v in values.items() if case.values[n] != other.values[n]})


def _cut(case: Case, failed: Sequence[Evaluation], oracle: _Oracle) -> Case:
    """The case with as few frames as its failures need; unchanged where they do not come again."""
    number = MEASURES.index(oracle.measure)
    ends = [e.result.robustness.ends[number] for e in failed if e.result.robustness]
    fps = failed[0].result.fps if failed else 0.0
    frames = max(ends, default=case.frames) + 1 + math.ceil(SPARE_S * fps)
    if frames >= case.frames:
        return case
    tried = case.with_values({"frames": frames})
    return tried if oracle.fails(tried) else case
