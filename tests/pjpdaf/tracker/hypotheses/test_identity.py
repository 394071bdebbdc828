"""Doubt of right and left after both hands were hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.hypothesis import Hypothesis
from pjpdaf.tracker.hypotheses.identity import either, halves_doubt, hidden_doubt, shifted
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters, IdentityParameters
from tests.pjpdaf.tracker.hypotheses.test_tracker import FRAME_S, START_W, nothing, seen, tracker

P = IdentityParameters(hidden_memory_s=2.0, hidden_speed_mps=0.5)


def hands(unseen_s: tuple[float, float], apart_m: float = 0.2) -> Hypothesis:
    means = np.array([[0.0, 0.0, 0.0], [0.0, apart_m, 0.0]])
    return Hypothesis(0.0, 0.0, means, np.tile(np.eye(3), (2, 1, 1)), np.array(unseen_s))


def test_it_grows_while_both_are_hidden_for_longer_than_a_change_of_places_takes():
    assert hidden_doubt(0.0, hands((0.3, 0.9)), 0.0, 0.3, P) == 0.0
    assert hidden_doubt(0.0, hands((0.0, 9.0)), 0.0, 0.3, P) == 0.0
    doubt, grown = 0.0, []
    for k in range(60):
        doubt = hidden_doubt(doubt, hands((0.5 + k / 3, 0.5 + k / 3)), 0.0, FRAME_S, P)
        grown.append(doubt)
    assert grown[5] == pytest.approx(0.5 * (1 - np.exp(-1.0)))  # 2 s
    assert np.all(np.diff(grown) > 0)
    assert grown[-1] == pytest.approx(0.5, abs=1e-3)


def test_it_is_the_same_at_every_frame_rate():
    for rate in (1, 30):
        doubt = 0.0
        for _ in range(2 * rate):
            doubt = hidden_doubt(doubt, hands((1.0, 1.0)), 0.0, 1 / rate, P)
        assert doubt == pytest.approx(0.5 * (1 - np.exp(-1.0)))


def test_sleeves_take_it_away_and_nothing_else_does():
    both = hands((0.0, 0.0))
    assert hidden_doubt(0.4, both, 0.0, FRAME_S, P) == pytest.approx(0.4)
    assert hidden_doubt(0.4, both, 2.0, FRAME_S, P) == pytest.approx(1 / (1 + 1.5 * np.exp(2.0)))
    assert hidden_doubt(0.4, both, -3.0, FRAME_S, P) == 0.5
    assert hidden_doubt(0.01, both, 6.0, FRAME_S, P) == 0.0


def test_without_the_parameter_there_is_none():
    off = IdentityParameters(hidden_memory_s=0.0)
    assert hidden_doubt(0.4, hands((9.0, 9.0)), 0.0, FRAME_S, off) == 0.0


def test_log_odds_shift_a_probability():
    assert shifted(0.0, 3.0) == 0.0
    assert shifted(0.3, 0.0) == pytest.approx(0.3)
    assert shifted(0.5, np.log(3.0)) == pytest.approx(0.75)


def test_two_exchanges_are_none():
    assert either(1.0, 1.0) == 0.0
    assert either(0.2, 0.0) == 0.2
    assert either(0.2, 0.5) == 0.5


def test_the_tracker_states_it_while_nobody_is_seen():
    one = tracker()
    state = one.start(seen(START_W))
    assert state is not None
    stated = []
    for _ in range(30):
        state, estimates = one.step(state, nothing(), FRAME_S)
        stated.append(estimates.exchange_probability)
    assert max(stated[:2]) < 0.06  # what the start leaves open
    assert stated[-1] > 0.45
    _, estimates = one.step(state, seen(START_W), FRAME_S)
    assert estimates.exchange_probability > 0.45  # without sleeves nothing tells them apart


def test_fast_hands_in_one_blob_may_be_named_wrongly():
    p = HypothesisParameters(identity=IdentityParameters(halves_doubt=0.1))
    rest = replace(hands((0.0, 0.0)), halves=(True, True))
    fast = replace(rest, speed_mps=0.24)  # 80 mm in a frame: motion counts half
    assert halves_doubt((rest,), FRAME_S, p) == 0.0
    assert halves_doubt((fast,), FRAME_S, p) == pytest.approx(0.05)
    assert halves_doubt((fast,), 1 / 30, p) < 0.001
    assert halves_doubt((replace(fast, halves=(True, False)),), FRAME_S, p) == 0.0
    off = replace(p, identity=IdentityParameters(halves_doubt=0.0))
    assert halves_doubt((fast,), FRAME_S, off) == 0.0
