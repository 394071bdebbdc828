"""Paired shares: coverage, symmetry, exact cases."""

from __future__ import annotations

import numpy as np
import pytest

from reports.gate.statistics import wilson
from scenarios.stress.paired import paired_failures


def outcomes(both: int, only_a: int, only_b: int, neither: int) -> tuple[list[bool], list[bool]]:
    a = [True] * both + [True] * only_a + [False] * only_b + [False] * neither
    b = [True] * both + [False] * only_a + [True] * only_b + [False] * neither
    return a, b


def test_unrelated_outcomes_have_the_interval_of_two_samples() -> None:
    # 4 * 9 = 6 * 6: no correlation, so the two Wilson intervals add in quadrature.
    result = paired_failures(*outcomes(4, 6, 6, 9))
    low, high = wilson(10, 25)
    reach = np.hypot(0.4 - low, high - 0.4)
    assert (result.low, result.difference, result.high) == pytest.approx((-reach, 0.0, reach))


def test_agreement_narrows_the_interval() -> None:
    apart = paired_failures(*outcomes(4, 6, 6, 9))
    alike = paired_failures(*outcomes(9, 1, 1, 14))
    assert alike.high - alike.low < 0.7 * (apart.high - apart.low)


def test_exchange_of_the_systems_turns_the_sign() -> None:
    a, b = outcomes(5, 9, 2, 30)
    there, back = paired_failures(a, b), paired_failures(b, a)
    assert (there.difference, there.low, there.high) == pytest.approx(
        (-back.difference, -back.high, -back.low)
    )
    assert there.p_value == back.p_value


def test_exact_mcnemar() -> None:
    # Ten differ, all one way: 2 / 2^10.
    assert paired_failures(*outcomes(3, 0, 10, 5)).p_value == pytest.approx(2 / 1024)
    assert paired_failures(*outcomes(3, 0, 0, 5)).p_value == 1.0


def test_interval_covers() -> None:
    rng = np.random.default_rng(0)
    p = np.array([0.1, 0.05, 0.2, 0.65])  # both, only a, only b, neither
    covered = 0
    for _ in range(200):
        result = paired_failures(*outcomes(*rng.multinomial(80, p).tolist()))
        covered += result.low <= 0.15 <= result.high
    assert covered >= 182


def test_without_a_draw_nothing_is_known() -> None:
    result = paired_failures([], [])
    assert (result.low, result.high, result.p_value) == (-1.0, 1.0, 1.0)
