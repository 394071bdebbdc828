import numpy as np
import pytest

from pjpdaf.camera import project, to_camera, triangulate
from sim.camera.miscalibration import miscalibrated
from sim.scene.rig import stereo_rig
from sim.specs import CalibrationError, RigSpec

RIG = stereo_rig(RigSpec(vergence_rad=0.0, tilt_rad=0.28))
POINTS_W = np.array([[0.34, -0.2, 0.8], [0.34, 0.22, 0.8], [0.1, 0.0, 1.2], [0.5, 0.05, 0.95]])


def believed(error, rig=RIG):
    """Where the true pixels of POINTS_W are by this calibration, in the left camera's frame."""
    wrong = miscalibrated(rig, error)
    found = []
    for point in POINTS_W:
        pixels = np.array([project(camera, point) for camera in rig.cameras])
        found.append(to_camera(wrong.left, triangulate(wrong.cameras, pixels)))
    return np.array(found)


TRUE = to_camera(RIG.left, POINTS_W)


def test_without_error_the_calibration_is_the_rig_itself():
    assert miscalibrated(RIG, CalibrationError()) is RIG


@pytest.mark.parametrize("share", [-0.05, 0.01, 0.05])
def test_a_longer_baseline_puts_everything_farther_by_the_same_share(share):
    np.testing.assert_allclose(believed(CalibrationError(baseline=share)), TRUE * (1 + share))


@pytest.mark.parametrize("share", [-0.03, 0.01, 0.03])
def test_a_longer_focal_length_stretches_depth_alone(share):
    """Z = f B / d; X = x Z / f."""
    expected = TRUE * [1, 1, 1 + share]
    np.testing.assert_allclose(believed(CalibrationError(focal=share)), expected)


@pytest.mark.parametrize("angle_deg", [-0.5, 0.1, 0.5])
def test_a_turn_about_y_is_an_error_of_disparity(angle_deg):
    """By the angle a, disparity is wrong by f a (1 + (x / f)^2): here to the second order in a."""
    a = np.radians(angle_deg)
    wrong = miscalibrated(RIG, CalibrationError(rotation_rad=(0.0, a, 0.0)))
    Z = believed(CalibrationError(rotation_rad=(0.0, a, 0.0)))[:, 2]
    f, B = 540.0, 0.09
    x = project(RIG.right, POINTS_W)[:, 0] - RIG.right.K[0, 2]
    disparity = f * B / TRUE[:, 2]
    # The right camera is believed to look along R(a): the same pixel is a ray turned back by a.
    shifted = disparity - f * (np.tan(np.arctan(x / f) - a) - x / f)
    np.testing.assert_allclose(Z, f * B / shifted, rtol=0.01)
    assert (np.sign(Z - TRUE[:, 2]) == -np.sign(a)).all()
    np.testing.assert_allclose(wrong.right.centre_w, RIG.right.centre_w)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_right_camera_turns_about_its_own_axes_and_the_left_one_stays(axis):
    turn = np.zeros(3)
    turn[axis] = np.radians(1.0)
    wrong = miscalibrated(RIG, CalibrationError(rotation_rad=tuple(turn)))
    np.testing.assert_array_equal(wrong.left.R_cw, RIG.left.R_cw)
    np.testing.assert_allclose(wrong.left.centre_w, RIG.left.centre_w, atol=1e-12)
    np.testing.assert_allclose(wrong.right.R_cw[axis], RIG.right.R_cw[axis], atol=1e-12)
    angle = np.arccos((np.trace(wrong.right.R_cw @ RIG.right.R_cw.T) - 1) / 2)
    assert np.degrees(angle) == pytest.approx(1.0)


def test_a_turn_about_x_takes_the_views_apart_vertically():
    error = CalibrationError(rotation_rad=(np.radians(0.5), 0.0, 0.0))
    wrong = miscalibrated(RIG, error)
    rows = project(RIG.right, POINTS_W)[:, 1] - project(wrong.right, POINTS_W)[:, 1]
    np.testing.assert_allclose(np.abs(rows), 540 * np.radians(0.5), rtol=0.08)


def test_lens_and_principal_point_stay():
    spec = RigSpec(distortion=(-0.1, 0.02, 0.0, 0.0), principal_offset_px=(5.0, -3.0))
    rig = stereo_rig(spec)
    wrong = miscalibrated(rig, CalibrationError(focal=0.02, baseline=0.02))
    for ours, theirs in zip(wrong.cameras, rig.cameras, strict=True):
        np.testing.assert_array_equal(ours.distortion, theirs.distortion)
        np.testing.assert_array_equal(ours.K[:2, 2], theirs.K[:2, 2])
        np.testing.assert_allclose(np.diag(ours.K)[:2], 540 * 1.02)
