"""Looking back: what later frames tell of an earlier one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pjpdaf.plugins.conformance import check_tracker
from pjpdaf.plugins.registry import make_tracker
from pjpdaf.tracker.hypotheses.lag import Past, look_back
from pjpdaf.tracker.hypotheses.tracker import HypothesisState
from tests.pjpdaf.tracker.hypotheses.test_tracker import (
    AREAS,
    FRAME_S,
    PLAIN,
    START_W,
    nothing,
    seen,
    tracker,
)

AWAY = START_W + np.array([[0.0, 0, 0], [0.0, 0, 0.12], [0.0, 0, 0]])


def states_of(*frames) -> tuple[HypothesisState, ...]:
    one = tracker()
    states = [one.start(frames[0])]
    for views in frames[1:]:
        states.append(one.step(states[-1], views, FRAME_S)[0])
    return tuple(states)


def test_of_one_state_alone_they_are_its_estimates():
    (first, second) = states_of(seen(START_W), seen(AWAY))
    assert tracker().smoothed((second,)) is second.estimates
    assert tracker().smoothed((first,)) is first.estimates


def test_a_hidden_hand_is_put_between_where_it_went_and_where_it_came_back():
    hidden = seen(START_W[[0, 2]], AREAS[[0, 2]])
    states = states_of(seen(START_W), hidden, hidden, seen(AWAY))
    filtered = states[1].estimates.positions_m
    heights = [
        tracker().smoothed(states[k:]).positions_m[1, 2] - START_W[1, 2] for k in range(len(states))
    ]
    assert heights[0] < 0.02 < heights[1] < heights[2] < heights[3]
    smoothed = tracker().smoothed(states[1:])
    np.testing.assert_allclose(smoothed.positions_m[[0, 2]], filtered[[0, 2]], atol=2e-3)
    assert np.trace(smoothed.covariances_m2[1]) < np.trace(states[1].estimates.covariances_m2[1])
    assert smoothed.status == ("tracked", "coasting", "tracked")


def test_without_any_detection_nothing_moves():
    states = states_of(seen(START_W), nothing(), nothing())
    np.testing.assert_allclose(tracker().smoothed(states).positions_m, START_W, atol=1e-6)


def test_the_preset_conforms_with_it():
    assert check_tracker(lambda cameras: make_tracker("default", cameras)) == ()


@pytest.mark.parametrize(("share", "right_m"), [(0.0, START_W[1]), (1.0, START_W[2])])
def test_costs_of_later_frames_count_by_their_share(share, right_m):
    """Frame 0 slightly prefers one account of the hands, frame 1 has children of the other."""
    state = states_of(seen(START_W))[0]
    (first,) = state.hypotheses[:1]
    other = dataclasses.replace(first, means=first.means[::-1], cost=0.5)
    child = dataclasses.replace(other, cost=0.0, parent=1)
    frames = [Past(state.head, (first, other), 0.0), Past(state.head, (child,), FRAME_S)]
    p = dataclasses.replace(PLAIN, later_share=share, mean_within=0.1)
    back = look_back(frames, state.estimates, tracker().views, p)
    np.testing.assert_allclose(back.positions_m[1], right_m, atol=1e-6)
