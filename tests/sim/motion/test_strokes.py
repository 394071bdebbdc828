"""Strokes: minimum jerk, bows, brakes, wobbles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.strokes import (
    PEAK_OVER_MEAN,
    Glide,
    HandPath,
    HandState,
    Stroke,
    minimum_jerk,
    minimum_jerk_rate,
    minimum_jerk_second,
    quaternion_of,
    stroke_duration,
    wobble,
)
from sim.person.kinematics import hand_rotation

ZERO = np.zeros(3)
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def at(*position, curl=0.1):
    return HandState(np.array(position, dtype=float), IDENTITY, np.full(5, curl))


def speeds(path, start_s, end_s, dt_s=1e-4):
    times = np.arange(start_s, end_s, dt_s)
    places = np.array([path.at(t).position_m for t in times])
    return np.linalg.norm(np.diff(places, axis=0), axis=1) / dt_s


def test_minimum_jerk_begins_and_ends_at_rest():
    assert [minimum_jerk(s) for s in (-1.0, 0.0, 0.5, 1.0, 2.0)] == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert minimum_jerk_rate(0.0) == minimum_jerk_rate(1.0) == 0.0
    assert minimum_jerk_rate(0.5) == PEAK_OVER_MEAN == 1.875


@given(s=st.floats(0.01, 0.99))
def test_derivatives_agree_with_differences(s):
    h = 1e-5
    assert minimum_jerk_rate(s) == pytest.approx(
        (minimum_jerk(s + h) - minimum_jerk(s - h)) / (2 * h), abs=1e-6
    )
    assert minimum_jerk_second(s) == pytest.approx(
        (minimum_jerk_rate(s + h) - minimum_jerk_rate(s - h)) / (2 * h), abs=1e-6
    )


@pytest.mark.long
@pytest.mark.parametrize("speed", [0.1, 0.5, 3.0])
def test_a_straight_stroke_peaks_at_1_875_a_over_t(speed):
    way = np.array([0.0, 0.35, 0.0])
    duration = stroke_duration(way, ZERO, speed)
    assert duration == pytest.approx(1.875 * 0.35 / speed)
    path = HandPath(at(0, 0, 0), (Stroke(1.0, duration, at(*way), ZERO),))
    assert speeds(path, 1.0, 1.0 + duration).max() == pytest.approx(speed, rel=1e-3)


@pytest.mark.long
@given(bow=st.tuples(*[st.floats(-0.1, 0.1)] * 3).map(np.array))
def test_a_bowed_stroke_peaks_at_the_speed_asked_for(bow):
    way = np.array([0.2, 0.1, 0.0])
    duration = stroke_duration(way, bow, 0.4)
    path = HandPath(at(0, 0, 0), (Stroke(0.0, duration, at(*way), bow),))
    # 101 samples of the speed find its peak to better than 0.3 %.
    assert speeds(path, 0.0, duration, 1e-3).max() == pytest.approx(0.4, rel=3e-3)


def test_a_path_holds_between_its_moves_and_after_them():
    path = HandPath(at(0, 0, 0), (Stroke(1, 1, at(1, 0, 0), ZERO), Stroke(4, 1, at(2, 0, 0), ZERO)))
    xs = [path.at(t).position_m[0] for t in (-1.0, 0.9, 1.5, 2.0, 3.0, 4.0, 5.0, 99.0)]
    assert xs == [0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 2.0, 2.0]


def test_rows_of_many_moments_are_those_of_each():
    left = HandState(np.array([0.3, 0.2, 0.8]), np.array([-0.6, 0.1, -0.7, 0.2]), np.full(5, 0.4))
    bow = np.array([0.0, 0.02, 0.1])
    first = at(0.4, -0.1, 0.9)
    strokes = (Stroke(0.5, 1.0, left, bow), Stroke(2.0, 0.7, at(0.2, 0.0, 1.0, curl=0.8), bow))
    glide = Glide(2.4, 0.5, left, bow, -bow, strokes[1].to, 0.2, 0.3)
    path = HandPath(first, (*strokes, glide))
    times = np.concatenate([np.linspace(-0.1, 3.5, 73), [0.5, 1.5, 2.0, 2.4]])
    for row, t_s in zip(path.rows(times), times.tolist(), strict=True):
        np.testing.assert_array_equal(row, path.at(t_s).row)
    assert float(left.quaternion @ first.quaternion) < 0  # the shorter way round


def test_moves_out_of_order_are_refused():
    with pytest.raises(ValueError, match="moves must be in order of time"):
        HandPath(at(0, 0, 0), (Stroke(4, 1, at(1, 0, 0), ZERO), Stroke(1, 1, at(1, 0, 0), ZERO)))


def test_a_glide_takes_over_a_broken_stroke_without_a_jump():
    start, goal, bow = at(0, 0, 0), at(0.35, 0, 0, curl=0.5), np.array([0.0, 0.02, 0.0])
    stroke = Stroke(0.0, 1.3, goal, bow)
    s, T = 0.45, 1.3
    u, rate, second = minimum_jerk(s), minimum_jerk_rate(s) / T, minimum_jerk_second(s) / T**2
    along = goal.position_m + 4 * (1 - 2 * u) * bow
    glide = Glide(
        start_s=s * T,
        duration_s=0.3,
        to=at(0.2, 0.01, 0.02),
        velocity_mps=rate * along,
        acceleration_mps2=second * along - 8 * rate**2 * bow,
        begun=start,
        begun_share=u,
        begun_rate=rate,
    )
    path = HandPath(start, (stroke, glide))
    h = 1e-4
    t = np.arange(s * T - 0.05, s * T + 0.05, h)
    places = np.array([path.at(x).position_m for x in t])
    accelerations = np.diff(places, 2, axis=0) / h**2
    # Twice differentiable: from sample to sample the acceleration moves by its slope only.
    assert np.abs(np.diff(accelerations, axis=0)).max() < 0.05
    end = path.at(glide.end_s)
    np.testing.assert_allclose(end.position_m, [0.2, 0.01, 0.02], atol=1e-12)
    assert np.linalg.norm(places[-1] - places[-2]) / h < 0.6


@given(yaw=st.floats(-3, 3), pitch=st.floats(-1.5, 1.5), roll=st.floats(-3, 3))
def test_quaternions_and_rotations_agree(yaw, pitch, roll):
    rotation = hand_rotation(0, yaw, pitch, roll)
    state = HandState(ZERO, quaternion_of(rotation), np.zeros(5))
    np.testing.assert_allclose(state.rotation, rotation, atol=1e-9)


def test_a_wobble_stays_within_its_amplitude_and_its_band():
    moved = wobble(np.random.default_rng(0), 0.01, 0.2, 0.5)
    t = np.arange(0.0, 200.0, 0.05)
    places = np.array([moved.at(x) for x in t])
    assert 0.004 < np.linalg.norm(places, axis=1).max() <= 0.01 + 1e-12
    assert moved.frequencies_hz.min() >= 0.2
    assert moved.frequencies_hz.max() <= 0.5
