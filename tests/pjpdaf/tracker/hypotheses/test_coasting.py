"""A hand that vanishes goes on, ever slower, the same at any frame rate."""

import numpy as np
import pytest

from pjpdaf.tracker.hypotheses.coasting import FASTEST_MPS, coasted, learnt_velocity

V = np.array([0.6, -0.2, 0.1])


def gone(times_s, coast_s):
    """Displacement after frames of these durations."""
    velocity, at = V, np.zeros(3)
    for dt_s in times_s:
        way, velocity = coasted(velocity, dt_s, coast_s)
        at = at + way
    return at


@pytest.mark.parametrize("frames", [1, 3, 30])
def test_the_way_depends_on_the_time_alone(frames):
    wanted = V * 0.35 * (1.0 - np.exp(-1.0 / 0.35))
    np.testing.assert_allclose(gone([1.0 / frames] * frames, 0.35), wanted, rtol=1e-12)


def test_in_all_it_goes_velocity_times_the_constant_and_without_one_it_stays():
    np.testing.assert_allclose(gone([1.0] * 60, 0.35), 0.35 * V, rtol=1e-9)
    np.testing.assert_array_equal(gone([1.0] * 3, 0.0), 0.0)


def test_a_steady_movement_is_learnt_at_any_rate():
    for fps in (3, 12, 30):
        velocity = np.zeros(3)
        for _ in range(fps):
            velocity = learnt_velocity(velocity, V / fps, 1.0 / fps)
        np.testing.assert_allclose(velocity, V, rtol=1e-3)


def test_noise_of_the_places_does_not_grow_with_the_rate():
    """10 mm a frame would be 0.42 m/s at 30 frames a second, and 0.15 m in all."""
    rng = np.random.default_rng(0)
    places = rng.normal(0.0, 0.01, (3000, 3))
    velocity, speeds = np.zeros(3), []
    for moved in np.diff(places, axis=0):
        velocity = learnt_velocity(velocity, moved, 1 / 30)
        speeds.append(np.linalg.norm(velocity))
    assert np.median(speeds) * 0.35 < 0.08


def test_a_jump_is_no_speed_and_no_time_says_nothing():
    assert np.linalg.norm(learnt_velocity(np.zeros(3), np.full(3, 2.0), 0.1)) <= FASTEST_MPS + 1e-9
    np.testing.assert_array_equal(learnt_velocity(V, np.ones(3), 0.0), V)
