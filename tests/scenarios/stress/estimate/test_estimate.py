"""The estimate on functions whose probability is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import norm

from pjpdaf.errors import BenchError
from scenarios.stress.estimate.estimate import estimate
from scenarios.stress.estimate.outcomes import Outcomes, Play
from scenarios.stress.estimate.probability import weighted
from scenarios.stress.estimate.proposal import Proposal

D = 20  # latents, of which at most three matter
RUNS = 3000


def outcomes(failed: np.ndarray, objective: np.ndarray) -> Outcomes:
    return Outcomes(failed, objective, np.ones(len(failed), dtype=bool))


def noise(seeds: np.ndarray) -> np.ndarray:
    """Standard-normal noise that a seed fixes."""
    return norm.ppf(((seeds * 2654435761) % 2**32 + 0.5) / 2**32)


def half_space(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
    """Three parameters and the noise add up."""
    gap = norm.isf(1e-3) - (z[:, :3].sum(axis=1) + 0.3 * noise(seeds)) / np.sqrt(3.09)
    return outcomes(gap < 0, np.clip(gap, -1, 3))


def two_sides(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
    gap = norm.isf(5e-4) - np.abs(z[:, 0])
    return outcomes(gap < 0, gap)


def two_corners(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
    gap = norm.isf(5e-4) - np.maximum(z[:, 0], z[:, 1])
    return outcomes(gap < 0, gap)


def cliff(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
    """As a swap: hands must come together (the objective sees it), then noise decides."""
    apart = np.maximum(0, 1.5 - z[:, :2]).sum(axis=1)
    failed = (apart == 0) & (noise(seeds) > norm.isf(0.3))
    return outcomes(failed, np.where(failed, -1.0, 1.0) + np.minimum(1, apart / 2))


KNOWN: dict[str, tuple[Play, float]] = {
    "half_space": (half_space, 1e-3),
    "two_sides": (two_sides, 1e-3),
    "two_corners": (two_corners, 1 - (1 - 5e-4) ** 2),
    "cliff": (cliff, norm.sf(1.5) ** 2 * 0.3),
}


def repeated(name: str, repeats: int, d: int = D) -> tuple[float, int, int]:
    """Relative RMSE, intervals that cover, and conclusive ones among `repeats` estimates."""
    play, p = KNOWN[name]
    results = [estimate(play, d, RUNS, seed)[0] for seed in range(repeats)]
    errors = np.array([r.p / p - 1 for r in results])
    covered = sum(r.low <= p <= r.high for r in results)
    good = sum(r.verdict == "estimated" for r in results)
    return float(np.sqrt(np.mean(errors**2))), covered, good


def test_rare_failures_are_estimated_within_a_fifth() -> None:
    # The same 3000 plain runs: three failures, relative RMSE 0.58.
    error, covered, good = repeated("half_space", 6)
    assert error <= 0.2
    assert covered >= 5
    assert good >= 5


@pytest.mark.long
@pytest.mark.parametrize("name", KNOWN)
def test_24_repeats(name: str) -> None:
    error, covered, _ = repeated(name, 24)
    assert error <= 0.2
    assert covered >= 22


def test_common_failures_are_counted_and_the_pilot_is_not() -> None:
    def common(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
        return outcomes(z[:, 0] > 1, -z[:, 0])

    result, _ = estimate(common, 4, 1200, 0)
    assert (result.method, result.runs, result.adaptation_runs) == ("plain", 1100, 100)
    assert result.low <= norm.sf(1) <= result.high


def test_no_draw_of_the_adaptation_is_in_the_estimate() -> None:
    batches: list[set[int]] = []

    def recorded(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
        batches.append(set(seeds.tolist()))
        return half_space(z, seeds)

    result, _ = estimate(recorded, 4, 1200, 0)
    assert result.method == "importance"
    assert sum(map(len, batches)) == len(set.union(*batches)) == 1200
    assert len(batches[-1]) == result.runs


def test_a_region_that_the_proposal_missed_makes_it_inconclusive() -> None:
    proposal = Proposal(np.ones(1), np.array([[3.0, 0.0]]), np.array([[0.6, 1.0]]))
    latents, nominal = proposal.sample(0, "estimate", 2000)
    weights = proposal.weights(latents, nominal / 2000)
    failed = latents[:, 0] > 3.0
    everything = np.ones(2000, dtype=bool)
    result = weighted(weights, failed, everything, nominal, 0)
    assert result.verdict == "estimated"
    assert result.low <= norm.sf(3.0) <= result.high
    # The same, and failures of about 0.002 at the other side: a few of the nominal draws.
    missed = weighted(weights, failed | (latents[:, 0] < -2.9), everything, nominal, 0)
    assert missed.verdict == "inconclusive"
    assert missed.largest_weight > 0.05


def test_without_a_failure_there_is_a_bound() -> None:
    def never(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
        return outcomes(np.zeros(len(z), dtype=bool), z[:, 0])

    result, _ = estimate(never, 3, 1200, 0)
    assert (result.verdict, result.p, result.low) == ("bound", 0.0, 0.0)
    assert result.high == pytest.approx(3 / result.runs, rel=0.02)


def test_draws_that_are_none_leave_the_whole() -> None:
    def posable(play: Play) -> Callable[[np.ndarray, np.ndarray], Outcomes]:
        def judged(z: np.ndarray, seeds: np.ndarray) -> Outcomes:
            all_ = play(z, seeds)
            return Outcomes(all_.failed, all_.objective, z[:, 4] < 0)

        return judged

    # Posing does not depend on what fails, so the share of the others is the same.
    results = [estimate(posable(half_space), 6, 1500, seed)[0] for seed in range(4)]
    assert np.mean([r.p for r in results]) == pytest.approx(1e-3, rel=0.2)


def test_the_same_seed_gives_the_same_estimate() -> None:
    first, again, other = (estimate(two_sides, 5, 600, seed)[0] for seed in (3, 3, 4))
    assert first == again
    assert first != other


def test_too_few_runs() -> None:
    with pytest.raises(BenchError, match="an estimate needs at least 24 runs, got 23"):
        estimate(two_sides, 5, 23, 0)
