"""Errors worked by hand, and that moving the world changes none of them."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pjpdaf.camera import Camera
from reports.score.records import Episode
from reports.score.score import lateral_and_depth, normalised_errors, quantile, score


def camera_at(centre_m):
    """Axes of the camera = axes of the world, looking along +z."""
    K = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
    return Camera(K, np.eye(3), -np.asarray(centre_m, float), 640, 480)


def test_lateral_and_depth_by_hand():
    # The ray to (0, 3, 4) is (0, .6, .8): an error of (.01, .03, .04) is 50 mm along it, 10 across.
    lateral, depth = lateral_and_depth(
        camera_at([0, 0, 0]), np.array([[0.01, 3.03, 4.04]]), np.array([[0.0, 3, 4]])
    )
    np.testing.assert_allclose([lateral[0], depth[0]], [0.010, 0.050], atol=1e-15)


def test_depth_is_negative_in_front_of_the_truth():
    lateral, depth = lateral_and_depth(
        camera_at([0, 0, 0]), np.array([[0.0, 0, 0.9]]), np.array([[0.0, 0, 1]])
    )
    np.testing.assert_allclose([lateral[0], depth[0]], [0, -0.1], atol=1e-15)


def test_depth_is_along_the_left_cameras_ray(episode_of, tools):
    centres = tools.paths(1, 3.0)
    ray = centres[0] - tools.cameras()[0].centre_w
    estimates = centres + 0.03 * ray / np.linalg.norm(ray, axis=1, keepdims=True)
    result = score(episode_of(estimates, centres_m=centres))
    np.testing.assert_allclose(result.depth_m[0], 0.03, atol=1e-12)
    np.testing.assert_allclose(result.lateral_m[0], 0, atol=1e-12)


def test_err_acc_is_the_mean_over_views_by_hand(episode_of, tools):
    # A hand 0.95 m in front of both cameras, estimate 9.5 mm to the person's left: 540 * 10e-3 px.
    # The head's truth is 1.25 m away, its estimate 25 mm too far: parallax .025 of the offset.
    centres = np.array([[[0.05, 0.0, 1.0], [0.35, 0.0, 1.0], [0.35, 0.3, 1.0]]])
    estimates = centres + np.array([[-0.025, 0, 0], [0, 0.0095, 0], [0, 0, 0]])
    result = score(episode_of(estimates, centres_m=centres))
    head = 540 * 0.045 * (1 / 1.25 - 1 / 1.275)
    np.testing.assert_allclose(result.err_acc_px[0], [head, 5.4, 0.0], atol=1e-9)
    np.testing.assert_allclose(result.error_m[0], [0.025, 0.0095, 0], atol=1e-12)


def test_err_acc_uses_the_visible_skin_and_the_centre_where_unseen(episode_of):
    episode = episode_of(frames=1)
    truth = episode.frames[0].truth
    marks = truth.views[0].centroids_px.copy()
    marks[1] += [3.0, 4.0]  # the skin that shows is 5 px from the centre
    marks[2] = np.nan  # unseen
    view = dataclasses.replace(truth.views[0], centroids_px=marks)
    truth = dataclasses.replace(truth, views=(view, truth.views[1]))
    outcome = dataclasses.replace(episode.frames[0], truth=truth)
    result = score(dataclasses.replace(episode, frames=(outcome,)))
    np.testing.assert_allclose(result.view_px[0, :, 0], [0, 5, 0], atol=1e-9)
    np.testing.assert_allclose(result.err_acc_px[0], [0, 2.5, 0], atol=1e-9)


def test_an_estimate_behind_the_cameras_is_infinitely_far_off_in_pixels(episode_of, tools):
    centres = tools.paths(1, 3.0)
    estimates = centres + np.array([[2.0, 0, 0], [0, 0, 0], [0, 0, 0]])
    result = score(episode_of(estimates, centres_m=centres))
    assert result.err_acc_px[0, 0] == np.inf
    assert result.error_m[0, 0] == pytest.approx(2.0)


def test_surface_error_is_against_the_visible_surface(episode_of):
    assert score(episode_of(frames=2)).surface_m == pytest.approx(np.full((2, 3), 0.015))


def test_waiting_frames_are_neither_covered_nor_within(episode_of, tools):
    estimates = tools.paths(4, 3.0)
    estimates[0, 1] = np.nan
    estimates[1, 1, 2] = np.nan  # one number missing is no estimate
    result = score(episode_of(estimates, frames=4))
    assert result.covered[:, 1].tolist() == [False, False, True, True]
    assert result.within(0.1)[:, 1].tolist() == [False, False, True, True]
    assert np.isnan(result.view_px[1, 1]).all()
    assert result.within(1e9).shape == (4, 3)


def test_merged_in_any_view_with_anything(episode_of):
    pair = np.zeros((3, 3), bool)
    pair[0, 2] = pair[2, 0] = True
    none = np.zeros((3, 3), bool)
    result = score(episode_of(frames=2, merged=lambda f: (none, pair if f == 1 else none)))
    assert result.merged.tolist() == [[False] * 3, [True, False, True]]


def test_nees_by_hand_and_without_an_inverse():
    P = np.array([np.diag([1.0, 4.0, 16.0]), np.zeros((3, 3))])
    found = normalised_errors(np.array([[1.0, 2.0, 8.0], [1, 1, 1]]), P)
    assert found[0] == pytest.approx(1 + 1 + 4)
    assert np.isnan(found[1])


def test_quantile_counts_silence_as_infinite():
    assert quantile(np.array([3.0, 1, 2]), 0.5) == 2
    assert quantile(np.array([1.0, 2, 3, 4]), 0.5) == 2.5
    assert quantile(np.array([1.0, np.nan, np.nan]), 0.5) == np.inf
    assert quantile(np.array([1.0, 2, np.inf]), 0.5) == 2
    assert np.isnan(quantile(np.zeros(0), 0.5))


@settings(max_examples=25, deadline=None)
@given(
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
    shift=st.tuples(*[st.floats(-5, 5)] * 3),
    seed=st.integers(0, 100),
)
def test_moving_world_and_cameras_together_changes_no_error(turn, shift, seed, episode_of, tools):
    centres = tools.paths(5, 3.0)
    estimates = tools.noisy(centres, seed, 0.05)
    R, s = Rotation.from_rotvec(turn).as_matrix(), np.array(shift)

    def moved(points):
        return points @ R.T + s

    def camera_moved(camera):
        turned = camera.R_cw @ R.T
        return dataclasses.replace(camera, R_cw=turned, t_cw=camera.t_cw - turned @ s)

    base: Episode = episode_of(estimates, centres_m=centres)
    frames = []
    for o in base.frames:
        truth = dataclasses.replace(
            o.truth, centres_m=moved(o.truth.centres_m), surfaces_m=moved(o.truth.surfaces_m)
        )
        said = dataclasses.replace(
            o.estimates,
            positions_m=moved(o.estimates.positions_m),
            covariances_m2=R @ o.estimates.covariances_m2 @ R.T,
        )
        frames.append(dataclasses.replace(o, truth=truth, estimates=said))
    there = dataclasses.replace(
        base, frames=tuple(frames), cameras=tuple(camera_moved(c) for c in base.cameras)
    )
    here_score, there_score = score(base), score(there)
    for field in dataclasses.fields(here_score):
        np.testing.assert_allclose(
            getattr(there_score, field.name),
            getattr(here_score, field.name),
            atol=1e-6,  # metres and pixels; positions of 5 m carry 1e-15 relative rounding
            err_msg=field.name,
        )


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000))
def test_lateral_and_depth_make_up_the_error(seed, episode_of, tools):
    centres = tools.paths(4, 3.0)
    result = score(episode_of(tools.noisy(centres, seed, 0.1), centres_m=centres))
    np.testing.assert_allclose(
        np.hypot(result.lateral_m, result.depth_m), result.error_m, rtol=1e-9
    )
