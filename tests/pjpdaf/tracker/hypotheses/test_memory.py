"""Memory that fades."""

from __future__ import annotations

import math

import pytest

from pjpdaf.tracker.hypotheses.memory import kept_share


def test_fading_in_steps_is_fading_at_once():
    assert kept_share(0.6, 2.0) == pytest.approx(kept_share(0.2, 2.0) ** 3)
    assert kept_share(2.0, 2.0) == pytest.approx(1 / math.e)


def test_without_memory_nothing_is_left():
    assert kept_share(0.1, 0.0) == 0.0
