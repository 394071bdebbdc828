"""Agreement of two ways to play the same cases: which of them fail, and by how much they err."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from reports.score.records import Episode
from reports.score.robustness import robustness


@dataclass(frozen=True, eq=False)
class CaseAgreement:
    """A case played twice, a and b.

    failed_a, failed_b: names of the measures below 0 (`reports.score.robustness`); errors_a_m,
    errors_b_m (T,): median errors of the targets; apart_m (T,): median distance of the estimates.
    """

    scenario: str
    seed: int
    failed_a: tuple[str, ...]
    failed_b: tuple[str, ...]
    errors_a_m: Floats
    errors_b_m: Floats
    apart_m: Floats


@dataclass(frozen=True)
class Confusion:
    """Numbers of cases that failed in both ways, in one only, and in none."""

    both: int
    only_a: int
    only_b: int
    none: int

    @staticmethod
    def of(cases: Sequence[CaseAgreement]) -> Confusion:
        """The counts of these cases."""
        pairs = [(bool(case.failed_a), bool(case.failed_b)) for case in cases]
        return Confusion(
            pairs.count((True, True)),
            pairs.count((True, False)),
            pairs.count((False, True)),
            pairs.count((False, False)),
        )

    @property
    def cases(self) -> int:
        """All cases."""
        return self.both + self.only_a + self.only_b + self.none

    @property
    def share(self) -> float:
        """Share of the cases in which both ways agree, NaN of none."""
        return (self.both + self.none) / self.cases if self.cases else float("nan")

    @property
    def kappa(self) -> float:
        """Cohen's kappa: agreement beyond chance, NaN where chance alone must agree."""
        n = self.cases
        a, b = self.both + self.only_a, self.both + self.only_b
        chance = (a * b + (n - a) * (n - b)) / n**2 if n else float("nan")
        return (self.share - chance) / (1.0 - chance) if n and chance < 1.0 else float("nan")


def case_agreement(a: Episode, b: Episode) -> CaseAgreement:
    """The agreement of a case's two episodes, of as many frames."""
    of_a, of_b = _estimates(a), _estimates(b)
    truths = np.stack([outcome.truth.centres_m for outcome in a.frames])
    return CaseAgreement(
        scenario=a.scenario,
        seed=a.seed,
        failed_a=robustness(a).failed,
        failed_b=robustness(b).failed,
        errors_a_m=_median_norm(of_a - truths),
        errors_b_m=_median_norm(of_b - truths),
        apart_m=_median_norm(of_a - of_b),
    )


def _estimates(episode: Episode) -> Floats:
    return np.stack([outcome.estimates.positions_m for outcome in episode.frames])


def _median_norm(offsets_m: Floats) -> Floats:
    """Medians over the frames (T,), NaN of a target that no frame has."""
    lengths = np.linalg.norm(offsets_m, axis=2)
    started = np.isfinite(lengths).all(axis=1)
    if not started.any():
        return np.full(lengths.shape[1], np.nan)
    return np.asarray(np.median(lengths[started], axis=0))
