"""Sequential tests of made-up cases that fail with a known share of all noise."""

import numpy as np
import pytest

from reports.score.robustness import Robustness
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.survival import LENIENT, STRICT, Oracle, Survival

CASE = Case("cross", {"frames": 20}, 0)


def failing_in(share):
    def evaluate(cases):
        bad = [np.random.default_rng(case.seed).random() < share for case in cases]
        rho = [
            Robustness(-1.0 if b else 1.0, 1.0, 1.0, (1.0,) * 3, (0.1,) * 3, (-1,) * 6) for b in bad
        ]
        return [Evaluation(c, TrialResult("k", r)) for c, r in zip(cases, rho, strict=True)]

    return evaluate


def accepted(share, rule, tests=150):
    """Share of the tests that accept, and episodes of a test."""
    oracle = Oracle(failing_in(share), "swap", iter(range(10**6)), most=10**6)
    hits = sum(oracle.fails(CASE, rule) for _ in range(tests))
    return hits / tests, oracle.runs / tests


def exact(p, rule):
    """The share that a rule accepts: a failure with probability p, one episode after another."""
    shares = {(0, 0): 1.0}
    total = 0.0
    while shares:
        (failed, passed), share = shares.popitem()
        if rule.next_batch(failed, passed) == 0:
            total += share if passed <= rule.passes else 0.0
            continue
        for state, part in (((failed + 1, passed), p), ((failed, passed + 1), 1 - p)):
            shares[state] = shares.get(state, 0.0) + share * part
    return total


@pytest.mark.parametrize(
    ("rule", "share", "low", "high"),
    [
        (STRICT, 0.95, 0.9, 0.95),
        (STRICT, 0.7, 0.2, 0.25),
        (STRICT, 0.2, 0.0, 0.001),
        (LENIENT, 0.75, 0.45, 0.55),
        (LENIENT, 0.5, 0.05, 0.1),
    ],
)
def test_a_rule_accepts_what_its_comment_says(rule, share, low, high):
    assert low < exact(share, rule) < high
    measured, _ = accepted(share, rule)
    assert measured == pytest.approx(exact(share, rule), abs=0.13)  # 3 deviations of 150 tests


def test_what_is_cured_costs_two_episodes():
    assert accepted(0.0, STRICT) == (0.0, 2.0)
    assert accepted(1.0, STRICT) == (1.0, 5.0)


def test_no_seed_is_used_twice_and_no_more_than_are_there():
    played = []

    def evaluate(cases):
        played.extend(case.seed for case in cases)
        return failing_in(0.9)(cases)

    oracle = Oracle(evaluate, "swap", iter(range(40)), most=40)
    while oracle.runs < 30:
        oracle.fails(CASE, STRICT)
    assert not oracle.fails(CASE, STRICT, kept_back=10)
    oracle.survival(CASE, 16, 16)
    assert oracle.runs == len(played) == 40
    assert sorted(set(played)) == played
    assert oracle.survival(CASE, 16, 16)[0].of == 0


def test_survival_as_text_and_share():
    assert Survival(7, 8).text == "7/8"
    assert Survival(7, 8).share == 7 / 8
    assert Survival(0, 0).share == 0.0
