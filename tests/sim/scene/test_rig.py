import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pjpdaf.camera import Camera, project
from sim.gl import load_mujoco
from sim.scene.rig import mujoco_camera, stereo_rig
from sim.specs import RigSpec

LEFT_HAND_W, RIGHT_HAND_W = np.array([0.35, 0.25, 0.80]), np.array([0.35, -0.25, 0.80])

rigs = st.builds(
    RigSpec,
    focal_px=st.floats(420, 700),
    baseline_m=st.floats(0.06, 0.3),
    height_m=st.floats(1.2, 1.6),
    distance_m=st.floats(1.1, 1.7),
    tilt_rad=st.floats(0, 0.44),
    vergence_rad=st.floats(0, 0.09),
    principal_offset_px=st.tuples(st.floats(-40, 40), st.floats(-40, 40)),
)


def test_a_parallel_rig_has_opencvs_baseline():
    rig = stereo_rig(RigSpec(baseline_m=0.09, vergence_rad=0.0, tilt_rad=0.3))
    np.testing.assert_allclose(rig.R, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rig.T, [-0.09, 0, 0], atol=1e-12)


@given(rigs)
def test_the_rig_stands_where_its_numbers_say(spec):
    rig = stereo_rig(spec)
    middle = (rig.left.centre_w + rig.right.centre_w) / 2
    np.testing.assert_allclose(middle, [spec.distance_m, 0, spec.height_m], atol=1e-12)
    assert np.linalg.norm(rig.T) == pytest.approx(spec.baseline_m)
    for camera in rig.cameras:
        np.testing.assert_allclose(camera.R_cw @ camera.R_cw.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(camera.R_cw) == pytest.approx(1.0)
        down = -camera.R_cw[2, 2]
        expected = np.sin(spec.tilt_rad) * np.cos(spec.vergence_rad / 2)
        assert down == pytest.approx(expected, abs=1e-12)
    turned = np.arccos(np.clip((np.trace(rig.R) - 1) / 2, -1, 1))
    assert turned == pytest.approx(spec.vergence_rad, abs=1e-7)


@given(rigs)
def test_left_is_left(spec):
    """The person faces the cameras: the left hand is on the right of both pictures."""
    rig = stereo_rig(spec)
    for camera in rig.cameras:
        assert project(camera, LEFT_HAND_W)[0] > project(camera, RIGHT_HAND_W)[0]
    # A nearer point lies further to the left in the right camera's picture.
    for hand in (LEFT_HAND_W, RIGHT_HAND_W):
        infinity = -spec.focal_px * spec.vergence_rad
        disparity = project(rig.left, hand)[0] - project(rig.right, hand)[0]
        assert disparity > infinity


def test_vergence_turns_the_axes_inwards():
    rig = stereo_rig(RigSpec(vergence_rad=0.08, tilt_rad=0.2))
    axes = [camera.R_cw[2] for camera in rig.cameras]
    # Points on the axes come nearer to each other along the way.
    start = rig.left.centre_w - rig.right.centre_w
    later = start + 0.5 * (axes[0] - axes[1])
    assert np.linalg.norm(later) < np.linalg.norm(start)


@given(rigs)
def test_mujoco_gets_the_same_pose_and_intrinsics(spec):
    mujoco = load_mujoco()
    camera = stereo_rig(spec).left
    scene = mujoco.MjSpec()
    scene.worldbody.add_camera(name="c", **mujoco_camera(camera))
    model = scene.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    R_cw = (data.cam("c").xmat.reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])).T
    np.testing.assert_allclose(R_cw, camera.R_cw, atol=1e-9)
    np.testing.assert_allclose(data.cam("c").xpos, camera.centre_w, atol=1e-9)
    # fx, fy, cx, cy in units of the sensor.
    assert model.cam_intrinsic[0, 0] / 1e-5 == pytest.approx(spec.focal_px, rel=1e-5)


def test_a_skewed_camera_is_refused():
    K = np.array([[500.0, 1.5, 320], [0, 500, 240], [0, 0, 1]])
    camera = Camera(K, np.eye(3), np.zeros(3), 640, 480)
    with pytest.raises(ValueError, match=r"no camera with skew, got K\[0, 1\] = 1.5"):
        mujoco_camera(camera)
