"""Distinct failures of a search, made up."""

from reports.score.robustness import Robustness
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.confirm import Counterexample
from scenarios.stress.search.distinct import DistinctFailure, Signature
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.survival import Survival


def evaluated(case: Case, rho: float) -> Evaluation:
    """A case whose hands have this robustness, all else well."""
    robustness = Robustness(rho, 1, 1, (1.0,) * 3, (0.1,) * 3, (-1,) * 6)
    return Evaluation(case, TrialResult("k", robustness))


def found(case: Case, full: Evaluation | None = None, survived: int = 4) -> Counterexample:
    """A swap in fast, with what became of it in full."""
    failure = DistinctFailure(Signature(case.family, "swap", ()), evaluated(case, -0.5), case)
    return Counterexample(failure, case, Survival(survived, survived), full)
