"""Sigma-lognormal strokes: closed form against integration, ends, peaks, overlap."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import lognorm

from sim.motion.lognormal import LognormalPiece, piece_of, talk_gesture
from sim.motion.strokes import HandPath, HandState, quaternion_of
from sim.person.kinematics import hand_rotation

SEEDS = range(100, 108)


def state(position, curl=0.1, inward=0.3):
    turned = quaternion_of(hand_rotation(0, inward, 0.1, 0.4))
    return HandState(np.array(position, dtype=float), turned, np.full(5, curl), air=1.0)


START = state([0.3, -0.2, 0.9])
STOPS = (state([0.4, -0.3, 1.0], 0.3, 0.6), state([0.28, -0.15, 1.05], 0.2, 0.1))


def gesture(seed, peaks=(0.8, 0.6), pause=-0.1):
    return talk_gesture(np.random.default_rng(seed), 2.0, START, STOPS, peaks, pause)


def piece(seed):
    rng = np.random.default_rng(seed)
    turn = float(rng.uniform(-2.0, 2.0))
    chord, normal = rng.normal(0.0, 0.2, 3), rng.normal(size=3)
    return piece_of(chord, turn, normal, 0.3, float(rng.uniform(0.1, 0.5)), 0.25), chord, turn


@pytest.mark.parametrize("seed", SEEDS)
def test_displacement_is_the_integral_of_the_velocity(seed):
    one, _, _ = piece(seed)
    times = np.linspace(one.onset_s, one.end_s, 4001)
    velocity = np.array([one.velocity(t) for t in times.tolist()])
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * (times[1] - times[0])
    # Trapezoids of 0.5 ms or less: second order in the step.
    summed = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    exact = np.array([one.moved(t) for t in times.tolist()])
    np.testing.assert_allclose(exact, summed, atol=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_speed_is_a_lognormal_impulse_and_the_direction_turns_with_its_share(seed):
    one, _, turn = piece(seed)
    law = lognorm(s=one.sigma, scale=np.exp(one.mu))
    for t in np.linspace(one.from_s, one.end_s, 23).tolist():
        since = t - one.onset_s
        velocity = one.velocity(t)
        assert np.linalg.norm(velocity) == pytest.approx(one.length_m * law.pdf(since), rel=1e-9)
        angle = np.arctan2(velocity @ one.aside, velocity @ one.along)
        assert angle == pytest.approx(turn * (law.cdf(since) - 0.5), abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_piece_spans_the_chord_asked_for(seed):
    one, chord, turn = piece(seed)
    np.testing.assert_allclose(one.moved(1e9), chord, atol=1e-12)
    assert one.length_m >= np.linalg.norm(chord)
    assert one.to_rad - one.from_rad == pytest.approx(turn)


def test_nothing_moves_before_the_onset():
    one = LognormalPiece(1.0, -1.0, 0.3, 0.2, np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    assert not one.moved(0.99).any()
    assert not one.velocity(1.0).any()
    assert one.moved(50.0) == pytest.approx([0.2, 0.0, 0.0])  # no turn: a straight piece


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gesture_begins_and_ends_where_it_should(seed):
    move = gesture(seed)
    first, last = move.at(move.start_s, START), move.at(move.end_s, START)
    # What is cut off at either end: 3e-6 of each piece.
    np.testing.assert_allclose(first.position_m, START.position_m, atol=1e-5)
    assert last is move.to
    near = move.at(move.end_s - 1e-6, START)
    np.testing.assert_allclose(near.position_m, STOPS[1].position_m, atol=1e-5)
    np.testing.assert_allclose(near.curls, STOPS[1].curls, atol=1e-4)
    np.testing.assert_allclose(near.rotation, STOPS[1].rotation, atol=1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_leg_is_2_to_5_overlapping_pieces_of_the_peak_speed_asked_for(seed):
    move = talk_gesture(np.random.default_rng(seed), 2.0, START, STOPS[:1], (0.7,))
    (pieces,) = move.pieces
    assert 2 <= len(pieces) <= 5
    for one, other in pairwise(pieces):
        assert other.from_s < one.end_s
    times = np.arange(move.start_s, move.end_s, 1e-3).tolist()
    places = np.array([move.at(t, START).position_m for t in times])
    fastest = np.linalg.norm(np.diff(places, axis=0), axis=1).max() / 1e-3
    assert fastest == pytest.approx(0.7, rel=0.02)  # the peak is sought on 161 points


def test_every_number_of_pieces_occurs():
    counts = {len(pieces) for seed in range(100, 140) for pieces in gesture(seed).pieces}
    assert counts == {2, 3, 4, 5}


@pytest.mark.parametrize("seed", SEEDS)
def test_the_path_is_smooth_from_rest_to_rest(seed):
    move = gesture(seed)
    path = HandPath(START, (move,))
    dt_s = 1e-3
    times = np.arange(move.start_s - 0.1, move.end_s + 0.1, dt_s).tolist()
    velocity = np.diff([path.at(t).position_m for t in times], axis=0) / dt_s
    jumps = np.linalg.norm(np.diff(velocity, axis=0), axis=1)
    assert jumps.max() < 0.04  # m/s in 1 ms: 40 m/s^2 is what a talking hand can do
    at_end = int((move.end_s - times[0]) / dt_s)
    # What is cut off, 3e-6 of the way, in one step of 1 ms.
    assert jumps[at_end - 2 : at_end + 2].max() < 1e-3


def test_legs_run_into_each_other_where_the_pause_is_negative():
    for seed in SEEDS:
        move = gesture(seed, pause=-0.15)
        first, second = move.pieces
        assert min(p.from_s for p in second) < max(p.end_s for p in first)
        rested = gesture(seed, pause=1.0)
        assert rested.end_s > move.end_s + 0.5


def test_a_gesture_is_pure_and_its_seed_decides():
    one, same, other = gesture(100), gesture(100), gesture(101)
    for t in (2.9, 2.1, 2.5):
        np.testing.assert_array_equal(one.at(t, START).position_m, same.at(t, START).position_m)
    assert not np.allclose(one.at(2.5, START).position_m, other.at(2.5, START).position_m)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gesture_is_the_vector_sum_of_its_pieces(seed):
    move = gesture(seed)
    for t in np.linspace(move.start_s, move.end_s - 1e-6, 17).tolist():
        summed = START.position_m + sum(p.moved(t) for leg in move.pieces for p in leg)
        np.testing.assert_allclose(move.at(t, START).position_m, summed, atol=1e-12)


def test_a_straight_leg_stays_on_its_line():
    for seed in SEEDS:
        move = talk_gesture(
            np.random.default_rng(seed), 0.0, START, STOPS, (0.7, 0.7), 0.2, straight=(0,)
        )
        way = STOPS[0].position_m - START.position_m
        leg = move.pieces[0]
        for t in np.linspace(0.0, 1.0, 9).tolist():
            moved = sum(p.moved(t) for p in leg)
            assert np.linalg.norm(np.cross(moved, way)) < 1e-12
