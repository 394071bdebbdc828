"""Curved paths: the two-thirds power law, rates, smooth ends."""

from __future__ import annotations

import numpy as np
import pytest

from sim.motion.curves import Rounds, curve_through, ellipse, figure_eight, ramped, rounds, sweep
from sim.motion.strokes import HandPath, HandState, minimum_jerk, quaternion_of
from sim.person.kinematics import hand_rotation

X, Y, Z = np.eye(3)
CENTRE = np.array([0.4, -0.1, 0.8])


def state(position, curl=0.1, inward=0.3):
    turned = quaternion_of(hand_rotation(0, inward, 0.1, 0.4))
    return HandState(np.array(position, dtype=float), turned, np.full(5, curl))


def speed_and_curvature(curve, count=4000):
    """By differences of `at` alone, over one round."""
    phases = np.linspace(0.0, 1.0, count + 1)
    places = np.array([curve.at(p) for p in phases[:-1].tolist()])
    h = 1.0 / count
    first = (np.roll(places, -1, axis=0) - np.roll(places, 1, axis=0)) / (2 * h)
    second = (np.roll(places, -1, axis=0) - 2 * places + np.roll(places, 1, axis=0)) / h**2
    speed = np.linalg.norm(first, axis=1)
    return speed, np.linalg.norm(np.cross(first, second), axis=1) / speed**3


def velocity_jumps(path, start_s, end_s, dt_s=1e-3):
    times = np.arange(start_s, end_s, dt_s).tolist()
    velocity = np.diff([path.at(t).position_m for t in times], axis=0) / dt_s
    return np.linalg.norm(np.diff(velocity, axis=0), axis=1)


@pytest.mark.parametrize("flat", [0.3, 0.5, 0.8])
def test_speed_goes_with_curvature_to_minus_a_third_on_an_ellipse(flat):
    speed, bent = speed_and_curvature(ellipse(0.06 * X, 0.06 * flat * Y, CENTRE))
    slope = np.polyfit(np.log(bent), np.log(speed), 1)[0]
    # The straightness constant, a twentieth of the mean curvature, flattens the law a little.
    assert slope == pytest.approx(-1 / 3, abs=0.05)
    length = speed.mean()
    law = (bent + 0.05 * 2 * np.pi / length) ** (-1 / 3)
    np.testing.assert_allclose(speed / law, np.mean(speed / law), rtol=2e-3)


def test_a_figure_eight_follows_the_law_through_its_crossing():
    speed, bent = speed_and_curvature(figure_eight(0.07 * X, 0.03 * Y, CENTRE))
    law = (bent + 0.05 * 2 * np.pi / speed.mean()) ** (-1 / 3)
    ratio = speed / law
    np.testing.assert_allclose(ratio, np.median(ratio), rtol=0.02)
    assert speed.max() / speed.min() < 5.0  # the straight crossing is fast, not infinitely so


def test_a_circle_is_run_through_evenly():
    curve = ellipse(0.05 * X, 0.05 * Y, CENTRE)
    speed, bent = speed_and_curvature(curve)
    np.testing.assert_allclose(speed, 2 * np.pi * 0.05, rtol=1e-3)
    np.testing.assert_allclose(bent, 20.0, rtol=2e-3)
    np.testing.assert_allclose(curve.at(0.25), CENTRE + 0.05 * Y, atol=1e-6)
    np.testing.assert_allclose(curve.at(3.25), curve.at(0.25), atol=1e-12)


def test_rate_is_the_derivative_of_the_place():
    for curve in (ellipse(0.06 * X, 0.02 * Y, CENTRE), curve_through(np.array([X, Y, Z, X + Z]))):
        for phase in (0.1, 0.37, 0.9):
            by_difference = (curve.at(phase + 1e-5) - curve.at(phase - 1e-5)) / 2e-5
            np.testing.assert_allclose(curve.rate(phase), by_difference, rtol=1e-4, atol=1e-4)


def test_an_open_curve_goes_through_its_points_and_stops_at_its_ends():
    points = np.array([[0, 0, 0], [0.2, 0.1, 0], [0.3, 0.1, 0.2], [0.3, -0.1, 0.3]], float)
    curve = curve_through(points)
    run = np.array([curve.at(p) for p in np.linspace(0, 1, 2001).tolist()])
    for point in points:
        assert np.linalg.norm(run - point, axis=1).min() < 1e-3
    np.testing.assert_allclose(curve.at(-1.0), points[0], atol=1e-12)
    np.testing.assert_allclose(curve.at(2.0), points[-1], atol=1e-12)


def test_points_on_top_of_each_other_are_refused():
    with pytest.raises(ValueError, match="each apart from the next"):
        curve_through(np.zeros((3, 3)))


def test_the_ramp_is_the_integral_of_a_smooth_rate():
    def rate(t):
        return minimum_jerk(t / 0.5) * minimum_jerk((3.0 - t) / 0.5)

    times = np.linspace(0.0, 3.0, 6001)
    rates = np.array([rate(t) for t in times.tolist()])
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * 5e-4)])
    exact = [ramped(t, 3.0, 0.5) for t in times.tolist()]
    np.testing.assert_allclose(exact, summed, atol=1e-6)
    assert ramped(-1.0, 3.0, 0.5) == 0.0
    assert ramped(9.0, 3.0, 0.5) == 2.5


@pytest.mark.parametrize("hertz", [0.3, 0.8, 1.4])
def test_rounds_keep_their_rate_and_begin_and_end_smoothly(hertz):
    start = state([0.35, -0.2, 0.78])
    made = rounds(1.0, start, ellipse(0.05 * X, 0.03 * Y, CENTRE), hertz, 8.0, 0.8)
    assert isinstance(made, Rounds)
    path = HandPath(start, (made,))
    np.testing.assert_allclose(path.at(1.0).position_m, start.position_m, atol=1e-12)
    np.testing.assert_allclose(path.at(8.999999).position_m, made.to.position_m, atol=1e-9)
    again = path.at(3.0).position_m - path.at(3.0 + 1.0 / hertz).position_m
    assert np.linalg.norm(again) < 1e-9
    assert velocity_jumps(path, 0.8, 9.3).max() < 8e-3 * max(hertz, 0.5) ** 2 + 1e-3
    places = np.array([path.at(t).position_m for t in np.arange(3.0, 7.0, 0.01).tolist()])
    np.testing.assert_allclose(np.ptp(places, axis=0), [0.1, 0.06, 0.0], atol=1e-3)


def test_a_sweep_passes_its_states_at_the_peak_speed_asked_for():
    states = [
        state([0.3, -0.2, 0.8], 0.1, 0.2),
        state([0.2, -0.4, 1.1], 0.5, 0.6),
        state([0.0, -0.2, 1.3], 0.3, 1.0),
    ]
    made = sweep(2.0, states, 0.6)
    path = HandPath(states[0], (made,))
    times = np.arange(2.0, made.end_s, 1e-3).tolist()
    run = [path.at(t) for t in times]
    places = np.array([s.position_m for s in run])
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / 1e-3
    assert speed.max() == pytest.approx(0.6, rel=0.01)
    assert speed[0] < 1e-3
    assert speed[-1] < 1e-3
    index = int(np.linalg.norm(places - states[1].position_m, axis=1).argmin())
    assert np.linalg.norm(places[index] - states[1].position_m) < 1e-3
    np.testing.assert_allclose(run[index].curls, states[1].curls, atol=5e-3)
    np.testing.assert_allclose(run[index].rotation, states[1].rotation, atol=1e-2)
    assert path.at(made.end_s) is states[2]
    assert velocity_jumps(path, 1.9, made.end_s + 0.1).max() < 0.02
    assert all((s.curls >= 0.1 - 1e-9).all() and (s.curls <= 0.5 + 1e-9).all() for s in run)


def test_speed_falls_where_a_sweep_turns():
    corner = [state([0.0, 0, 1]), state([0.2, 0, 1]), state([0.2, 0.2, 1])]
    curve = sweep(0.0, corner, 1.0).curve
    phases = np.linspace(0.02, 0.98, 400).tolist()
    speed = [np.linalg.norm(curve.rate(p)) for p in phases]
    places = np.array([curve.at(p) for p in phases])
    at_corner = int(np.linalg.norm(places - corner[1].position_m, axis=1).argmin())
    assert speed[at_corner] < 0.8 * max(speed)
