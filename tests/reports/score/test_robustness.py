"""Robustness on constructed paths, and against the events of the same episodes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from point_episodes import all_seen, apart, crossing, merging
from point_episodes import episode_of as tracked

from reports.score.events import find_events
from reports.score.robustness import LOSSES, MEASURES, measures_of, robustness

HEAD, RIGHT, LEFT = 0, 1, 2


def swapped(centres, first, last=None, order=(HEAD, LEFT, RIGHT)):
    estimates = centres.copy()
    estimates[first:last] = estimates[first:last][:, order]
    return estimates


def test_a_perfect_tracker_is_as_robust_as_can_be(episode_of):
    result = robustness(episode_of())
    assert result.measures == pytest.approx(dict.fromkeys(MEASURES, 1.0))
    assert result.failed == ()
    assert result.ends == (-1,) * 6
    # Hands 0.24 m apart and more: nothing draws a search to it.
    assert result.objective("swap") == pytest.approx(2.0)


def test_swapped_hands_for_half_a_second(episode_of, tools):
    centres = tools.paths(30, 3.0)
    result = robustness(episode_of(swapped(centres, 10, 12)))
    assert result.swap == pytest.approx(-1.0)
    assert result.failed[0] == "swap"
    assert result.ends[0] == 11
    assert robustness(episode_of(swapped(centres, 10, 11))).swap == pytest.approx(1.0)


def test_head_swapped_with_a_hand(episode_of, tools):
    centres = tools.paths(30, 3.0)
    result = robustness(episode_of(swapped(centres, 10, 20, order=(RIGHT, HEAD, LEFT))))
    assert result.head_right == pytest.approx(-1.0)
    assert result.swap > 0
    assert result.objective("head") < result.objective("swap")


def test_loss_is_measured_by_the_least_error_of_a_second(episode_of, tools):
    centres = tools.paths(30, 3.0)
    estimates = centres.copy()
    estimates[5:8, LEFT, 2] += [0.3, 0.21, 0.4]
    result = robustness(episode_of(estimates))
    assert result.lost == pytest.approx((1.0, 1.0, (0.15 - 0.21) / 0.15))
    assert result.ends[MEASURES.index("lost_left")] == 7
    estimates[6, LEFT, 2] -= 0.2
    assert robustness(episode_of(estimates)).lost[LEFT] == pytest.approx((0.15 - 0.01) / 0.15)


def test_a_tracker_that_gives_nothing_is_lost(episode_of, tools):
    centres = tools.paths(12, 3.0)
    result = robustness(episode_of(np.full_like(centres, np.nan), centres_m=centres))
    assert result.failed == tuple(LOSSES)
    assert result.coalescence_m == (1.0, 1.0, 1.0)


def test_coalesced_estimates_lead_a_search_to_the_swap(episode_of, tools):
    centres = tools.paths(12, 3.0)
    near = centres.copy()
    near[6, LEFT] = near[6, RIGHT] + [0.0, 0.1, 0.0]
    far, close = (robustness(episode_of(paths, centres_m=centres)) for paths in (centres, near))
    assert close.coalescence_m[0] == pytest.approx(0.1)
    assert close.objective("swap") == pytest.approx(far.objective("swap") - 0.5)
    # The lost hand of one frame changes no rho, as it makes no event.
    assert close.swap == pytest.approx(1.0)


def test_measures_of_goals():
    assert measures_of(("swap",)) == ("swap",)
    assert measures_of(("swap", "head", "lost")) == MEASURES


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), fps=st.sampled_from([1.0, 3.0, 4.0]), gap=st.floats(0.03, 0.3))
def test_negative_where_and_only_where_there_is_the_event(episode_of, seed, fps, gap):
    """Random walks of truth and estimates, exchanged, missing and far off in some frames."""
    rng = np.random.default_rng(seed)
    centres = np.cumsum(rng.normal(0, 0.03, (24, 3, 3)), axis=0)
    centres[:, LEFT] = centres[:, RIGHT] + rng.normal(0, gap, (24, 3))
    estimates = centres + rng.normal(0, 0.06, centres.shape)
    for first in rng.integers(0, 24, 3):
        estimates = swapped(estimates, first, first + int(rng.integers(1, 5)))
    estimates[rng.random((24, 3)) < 0.1] = np.nan
    estimates[: int(rng.integers(0, 4))] = np.nan
    episode = episode_of(estimates, centres_m=centres, fps=fps)
    kinds = {(e.kind, e.target) for e in find_events(episode)}
    result = robustness(episode)
    assert (result.swap < 0) == (("swap", RIGHT) in kinds)
    for target, rho in enumerate(result.lost):
        assert (rho < 0) == (("lost", target) in kinds)


def test_of_a_real_tracker():
    assert robustness(tracked(apart, all_seen)).failed == ()
    calm, crossed = (robustness(tracked(m, merging)) for m in (apart, crossing))
    assert crossed.objective("swap") < calm.objective("swap")
