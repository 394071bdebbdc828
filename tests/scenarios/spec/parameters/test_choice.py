"""Choices by weight."""

from __future__ import annotations

from scenarios.spec.parameters.choice import Choice


def test_choices_come_with_their_weights():
    coin = Choice(choices=("right", "left"), weights=(3, 1))
    assert [coin.quantile(s) for s in (0.0, 0.74, 0.76, 0.999)] == [
        "right",
        "right",
        "left",
        "left",
    ]
    assert Choice(choices=("a", "b"), weights=(1, 0)).quantile(1.0) == "a"
