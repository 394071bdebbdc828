import hashlib
import os
import subprocess
import sys
import threading
from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera, StereoRig, distort_points, project, to_camera
from pjpdaf.errors import InfrastructureError
from sim.camera import selftest
from sim.camera.render import StereoRenderer
from sim.camera.selftest import ellipse_centre
from sim.gl import load_mujoco
from sim.labels import back_project
from sim.person.rest import rest_pose
from sim.scene.rig import stereo_rig
from sim.scene.world import build, compiled
from sim.specs import ObjectSpec, RigSpec, RoomSpec, SceneSpec

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28), room=RoomSpec(objects=(CAN,)))
SMALL = replace(SCENE.rig, focal_px=270.0, width_px=320, height_px=240)
SMALL_SCENE = replace(SCENE, rig=SMALL)


def off_centre(lens=()):
    """A converging, tilted rig with fx != fy and the principal point far off-centre."""
    rig = stereo_rig(RigSpec(tilt_rad=0.25, vergence_rad=0.06))
    K = np.array([[520.0, 0, 333.25], [0, 493.0, 201.5], [0, 0, 1]])
    cameras = [
        Camera(
            K + np.array([[0, 0, 21.5 * side], [0, 0, 0], [0, 0, 0]]),
            c.R_cw,
            c.t_cw,
            640,
            480,
            np.array(lens),
        )
        for side, c in zip((-1, 1), rig.cameras, strict=True)
    ]
    return StereoRig(*cameras)


RIGS = {
    "plain": stereo_rig(RigSpec(tilt_rad=0.28)),
    "off-centre": off_centre(),
}


def spheres(camera, depths_m, radius_m):
    """World centres of spheres that cover the picture of a camera, kept off its border."""
    found = []
    for i, v in enumerate(np.linspace(50, 430, 5)):
        for j, u in enumerate(np.linspace(50, 590, 7)):
            z = depths_m[(3 * i + 5 * j) % len(depths_m)]
            ray = np.linalg.inv(camera.K) @ np.array([u, v, 1.0])
            found.append(camera.R_cw.T @ (ray * z - camera.t_cw))
    return np.array(found), np.full(len(found), radius_m)


def sphere_world(rig, centres_w, radii_m):
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.visual.quality.numslices, spec.visual.quality.numstacks = 96, 48
    for centre, radius in zip(centres_w, radii_m, strict=True):
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], pos=centre.tolist()
        )
    return compiled(spec, rig)


@pytest.mark.parametrize("name", RIGS)
def test_spheres_are_where_the_cameras_say(name):
    """Centroid of ids against the centre of the projected ellipse, over the whole picture."""
    rig = RIGS[name]
    offsets = []
    for view, camera in enumerate(rig.cameras):
        centres, radii = spheres(camera, (0.9, 1.2, 1.6, 2.1), 0.035)
        with StereoRenderer(sphere_world(rig, centres, radii)) as renderer:
            geoms = renderer.render(colour=False, amodal=False)[view].geoms
        for k, (centre, radius) in enumerate(zip(centres, radii, strict=True)):
            ys, xs = np.nonzero(geoms == k)
            assert len(xs) > 100
            offsets.append([xs.mean(), ys.mean()] - ellipse_centre(camera, centre, radius))
    offsets = np.array(offsets)
    assert np.abs(offsets.mean(axis=0)).max() <= 0.02
    assert np.abs(offsets).max() <= 0.15


@pytest.mark.parametrize("name", RIGS)
def test_the_depth_of_planes_has_no_offset(name):
    """1 / z of a plane is affine in (u, v): an offset of the pixel grid would shift it."""
    mujoco = load_mujoco()
    rig = RIGS[name]
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="plane", mocap=True)
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[5, 5, 0.001])
    world = compiled(spec, rig)
    rng = np.random.default_rng(5)
    v, u = np.mgrid[:480, :640]
    rows, errors = [], []
    with StereoRenderer(world) as renderer:
        for _ in range(12):
            towards = rig.left.R_cw.T @ np.array([*rng.uniform(-0.6, 0.6, 2), -1.0])
            normal = towards / np.linalg.norm(towards)
            centre = rig.left.R_cw.T @ (np.array([0, 0, rng.uniform(1.2, 2.0)]) - rig.left.t_cw)
            quat = np.zeros(4)
            mujoco.mju_quatZ2Vec(quat, normal)
            world.data.mocap_pos[0], world.data.mocap_quat[0] = centre, quat
            world.settle()
            point = centre + 0.001 * normal
            for camera, view in zip(
                rig.cameras, renderer.render(colour=False, amodal=False), strict=True
            ):
                n_c = camera.R_cw @ normal
                d = n_c @ to_camera(camera, point)
                a, b, c = (n_c / d) @ np.linalg.inv(camera.K)
                seen = view.geoms == 0
                inverse = 1 / view.depth_m[seen].astype(np.float64)
                error = inverse - (a * u[seen] + b * v[seen] + c)
                assert np.abs(error).max() < 2e-5  # 0.02 mm at 1 m: float32 and the plane's edge
                rows.append([a, b])
                errors.append(error.mean())
    offset = np.linalg.lstsq(np.array(rows), np.array(errors), rcond=None)[0]
    assert np.abs(offset).max() <= 1e-3


def test_depth_is_planar_and_not_along_the_ray():
    """A wall that faces the camera has one depth all over."""
    mujoco = load_mujoco()
    rig = stereo_rig(RigSpec(tilt_rad=0.0))
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5, 5, 5], pos=[-1.5, 0, 1.0])
    with StereoRenderer(compiled(spec, rig)) as renderer:
        for view in renderer.render(colour=False, amodal=False):
            np.testing.assert_allclose(view.depth_m, 2.3, atol=1e-5)


def test_left_depth_seen_from_the_right_agrees_with_the_right_ids():
    """Each left pixel with its depth, projected into the right picture, falls on the same body."""
    world = build(SCENE)
    world.place(rest_pose(SCENE.anatomy))
    with StereoRenderer(world) as renderer:
        left, right = renderer.render(colour=False, amodal=False)
    for target in range(3):
        # One pixel inside the outline, where rounding to the nearest pixel cannot leave the body.
        inside = cv2.erode((left.targets == target).astype(np.uint8), np.ones((3, 3))) > 0
        ys, xs = np.nonzero(inside)
        points = back_project(world.rig.left, xs, ys, left.depth_m[ys, xs])
        at = project(world.rig.right, points)
        z = to_camera(world.rig.right, points)[:, 2]
        c, r = np.rint(at).astype(int).T
        same = right.targets[r, c] == target
        nearer = right.depth_m[r, c] < z - 0.004  # hidden from the right eye
        near = np.abs(right.depth_m[r, c] - z) < 0.004
        assert (same | nearer).mean() > 0.99
        assert near[same].mean() > 0.93


def test_the_lens_moves_colour_and_labels_as_opencv_says():
    lens = (-0.22, 0.06, 0.0012, -0.0008, 0.0)
    ideal, real = off_centre(), off_centre(lens)
    centres, radii = spheres(ideal.left, (1.2, 1.6), 0.03)
    with StereoRenderer(sphere_world(real, centres, radii)) as renderer:
        view = renderer.render(colour=True, amodal=False)[0]
    assert view.colour.shape == (480, 640, 3)
    offsets = []
    for k, (centre, radius) in enumerate(zip(centres, radii, strict=True)):
        ys, xs = np.nonzero(view.geoms == k)
        if not len(xs) > 0 or min(xs.min(), ys.min()) == 0 or xs.max() == 639 or ys.max() == 479:
            continue
        # Small enough that the lens is affine over the sphere, to a fraction of the tolerance.
        expected = distort_points(real.left, ellipse_centre(ideal.left, centre, radius)[None])[0]
        offsets.append([xs.mean(), ys.mean()] - expected)
    assert len(offsets) > 20
    assert np.abs(np.mean(offsets, axis=0)).max() < 0.05
    assert np.abs(offsets).max() < 0.3


def test_a_lens_too_strong_is_refused():
    with pytest.raises(ValueError, match="too strong to render"):
        build(SceneSpec(rig=RigSpec(distortion=(-0.9, 0.0, 0.0, 0.0))))


def digest(views):
    found = hashlib.sha256()
    for view in views:
        for part in (view.colour, view.depth_m, view.geoms, view.targets, view.amodal):
            found.update(np.ascontiguousarray(part).tobytes())
    return found.hexdigest()


def rendered_digest():
    world = build(SMALL_SCENE)
    world.place(rest_pose(SMALL_SCENE.anatomy))
    with StereoRenderer(world) as renderer:
        return digest(renderer.render())


def test_the_same_bytes_again_beside_another_renderer_and_in_other_processes():
    world, other = build(SMALL_SCENE), build(SceneSpec(rig=SMALL))
    pose = rest_pose(SMALL_SCENE.anatomy)
    world.place(pose)
    other.place(pose)
    with StereoRenderer(world) as renderer, StereoRenderer(other) as second:
        first = digest(renderer.render())
        apart = digest(second.render())
        assert first != apart
        assert digest(renderer.render()) == first
        assert digest(second.render()) == apart
        second.close()
        assert digest(renderer.render()) == first
    code = (
        "import importlib.util as u;"
        f"s = u.spec_from_file_location('t', {__file__!r}); m = u.module_from_spec(s);"
        "s.loader.exec_module(m); print(m.rendered_digest())"
    )
    running = [
        subprocess.Popen(
            [sys.executable, "-c", code],
            env={**os.environ, "LP_NUM_THREADS": threads},
            stdout=subprocess.PIPE,
            text=True,
        )
        for threads in ("0", "1")
    ]
    assert [process.communicate(timeout=600)[0].strip() for process in running] == [first, first]


def test_a_renderer_knows_its_limits():
    world = build(SMALL_SCENE)
    renderer = StereoRenderer(world)
    faults = []

    def elsewhere():
        try:
            renderer.render()
        except ValueError as fault:
            faults.append(str(fault))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert faults == ["a StereoRenderer belongs to the thread that made it"]
    renderer.close()
    renderer.close()
    with pytest.raises(ValueError, match="is closed"):
        renderer.render()


def test_passes_can_be_left_out():
    world = build(SMALL_SCENE)
    world.place(rest_pose(SMALL_SCENE.anatomy))
    with StereoRenderer(world) as renderer:
        view = renderer.render(colour=False, labels=False, amodal=False)[0]
        assert (view.colour, view.depth_m, view.geoms, view.targets, view.amodal) == (None,) * 5


def test_the_self_test_passes_and_sees_a_wrong_principal_point(monkeypatch):
    assert np.abs(selftest.offsets_px(selftest.turned_rig())).max() < 0.2
    selftest.check()
    right = selftest.ellipse_centre
    monkeypatch.setattr(selftest, "ellipse_centre", lambda *a: right(*a) + np.array([0.5, 0.0]))
    with pytest.raises(InfrastructureError, match=r"self-test failed: a sphere is 0\.\d+ px from"):
        selftest.check()
