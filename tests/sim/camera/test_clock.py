import numpy as np
import pytest
from scipy.stats import binom

from sim.camera.clock import MOST_OF_PERIOD, moment
from sim.specs import ClockSpec

VIEWS = ("left", "right")


def moments(clock, fps=3.0, seed=100, count=400):
    return [moment(clock, fps, seed, index, VIEWS) for index in range(count)]


def test_without_jitter_frames_are_on_time_and_all_arrive():
    for index, now in enumerate(moments(ClockSpec(), fps=7.0)):
        assert now.time_s == now.stamp_s == index / 7.0
        assert now.arrived == (True, True)


@pytest.mark.parametrize("seed", [100, 101, 102])
@pytest.mark.parametrize("fps", [1.0, 3.0, 15.0, 30.0])
def test_jitter_is_bounded_even_and_keeps_the_order(fps, seed):
    found = moments(ClockSpec(jitter_s=0.05), fps, seed)
    late = np.array([now.time_s - index / fps for index, now in enumerate(found)])
    reach = min(0.05, MOST_OF_PERIOD / fps)
    assert np.abs(late).max() <= reach
    assert late.min() < -0.9 * reach
    assert late.max() > 0.9 * reach
    assert abs(late.mean()) < 4 * reach / np.sqrt(3 * len(late))
    assert late.std() == pytest.approx(reach / np.sqrt(3), rel=0.1)
    times = np.array([now.time_s for now in found])
    assert times[0] >= 0
    assert np.diff(times).min() > 0.09 / fps
    assert [now.stamp_s for now in found] == times.tolist()


def test_nominal_stamps_hide_the_jitter():
    clock = ClockSpec(jitter_s=0.05, stamps="nominal")
    actual = moments(ClockSpec(jitter_s=0.05))
    for index, (now, same) in enumerate(zip(moments(clock), actual, strict=True)):
        assert now.stamp_s == index / 3.0
        assert now.time_s == same.time_s


@pytest.mark.parametrize("seed", [100, 101, 102])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_pictures_are_lost_at_their_share_and_each_view_for_itself(share, seed):
    found = np.array([now.arrived for now in moments(ClockSpec(dropped=share), 3.0, seed, 2000)])
    low, high = binom.interval(1 - 1e-5, len(found), share)
    for view in (0, 1):
        assert low <= (~found[:, view]).sum() <= high
    low, high = binom.interval(1 - 1e-5, len(found), share**2)
    assert low <= (~found).all(axis=1).sum() <= high


def test_all_or_none_can_be_lost():
    assert not any(any(now.arrived) for now in moments(ClockSpec(dropped=1.0), count=50))
    assert all(all(now.arrived) for now in moments(ClockSpec(dropped=0.0), count=50))


def test_a_frame_does_not_depend_on_the_others_nor_jitter_on_losses():
    both, jitter = ClockSpec(jitter_s=0.05, dropped=0.1), ClockSpec(jitter_s=0.05)
    straight = moments(both, count=20)
    assert [moment(both, 3.0, 100, index, VIEWS) for index in range(19, -1, -1)] == straight[::-1]
    assert [now.time_s for now in moments(jitter, count=20)] == [now.time_s for now in straight]
    assert [now.time_s for now in moments(both, seed=101, count=20)][1:] != [
        now.time_s for now in straight
    ][1:]
