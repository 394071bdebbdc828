"""The lens against OpenCV: markers all over the picture are where cv2.projectPoints says."""

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera, distort_points, undistort_points
from sim.camera.render import StereoRenderer
from sim.gl import load_mujoco
from sim.lens import check, finer, ideal_pixels, lens_of, real_pixels
from sim.randomness import generator
from sim.scene.rig import stereo_rig
from sim.scene.world import compiled
from sim.specs import RigSpec

DEPTH_M = 1.3
LENSES = {
    "none": (),
    "barrel": (-0.30, 0.10, 0.0, 0.0),
    "pincushion": (0.15, 0.0, 0.0, 0.0),
    "tangential as well": (-0.25, 0.05, 0.001, -0.0008),
}


def rig_with(lens):
    return stereo_rig(RigSpec(distortion=lens, principal_offset_px=(7.3, -4.6), tilt_rad=0.28))


def markers(camera, radius_px):
    """World centres and radius of bright balls that cover the real picture."""
    real = np.array([(u, v) for v in np.linspace(30, 450, 6) for u in np.linspace(30, 610, 8)])
    ideal = undistort_points(camera, real)
    rays = np.column_stack([ideal, np.ones(len(ideal))]) @ np.linalg.inv(camera.K).T
    return (rays * DEPTH_M - camera.t_cw) @ camera.R_cw, radius_px / camera.K[0, 0] * DEPTH_M


def expected_centroid(camera, centre_w, radius_m):
    """Centroid of a ball's outline: the projected ellipse, through cv2.projectPoints, its area."""
    c = camera.R_cw @ centre_w + camera.t_cw
    dual = camera.K @ (np.outer(c, c) - radius_m**2 * np.eye(3)) @ camera.K.T
    dual /= dual[2, 2]
    middle = dual[:2, 2]
    root = np.linalg.cholesky(np.outer(middle, middle) - dual[:2, :2])
    turn = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    outline = middle + np.column_stack([np.cos(turn), np.sin(turn)]) @ root.T
    rays = np.column_stack([outline, np.ones(len(outline))]) @ np.linalg.inv(camera.K).T
    lens = np.array(camera.distortion) if len(camera.distortion) else np.zeros(4)
    zero = np.zeros(3)
    shown = cv2.projectPoints(rays, zero, zero, np.array(camera.K), lens)[0].reshape(-1, 2)
    after = np.roll(shown, -1, axis=0)
    cross = shown[:, 0] * after[:, 1] - after[:, 0] * shown[:, 1]
    return ((shown + after) * cross[:, None]).sum(axis=0) / (3 * cross.sum())


def offsets(lens, radius_px=12.0):
    """Rendered minus expected centroids (n, 2) [px]: of the colours, of the ids."""
    mujoco = load_mujoco()
    rig = rig_with(lens)
    camera = rig.left
    centres, radius_m = markers(camera, radius_px)
    spec = mujoco.MjSpec()
    spec.visual.quality.numslices, spec.visual.quality.numstacks = 96, 48
    spec.visual.headlight.active = 1
    spec.visual.headlight.ambient = [1, 1, 1]
    spec.visual.headlight.diffuse = spec.visual.headlight.specular = [0, 0, 0]
    sphere = mujoco.mjtGeom.mjGEOM_SPHERE
    for centre in centres:
        white = [1.0, 1.0, 1.0, 1.0]
        spec.worldbody.add_geom(type=sphere, size=[radius_m, 0, 0], pos=centre.tolist(), rgba=white)
    with StereoRenderer(compiled(spec, rig)) as renderer:
        view = renderer.view(0, amodal=False)
    of_colour, of_ids = [], []
    y, x = np.mgrid[:480, :640]
    for k, centre in enumerate(centres):
        wanted = expected_centroid(camera, centre, radius_m)
        mine = view.geoms == k
        of_ids.append([x[mine].mean() - wanted[0], y[mine].mean() - wanted[1]])
        around = np.hypot(x - wanted[0], y - wanted[1]) < 2.2 * radius_px
        light = np.where(around, view.colour[..., 1].astype(float), 0.0)
        at = np.array([(light * x).sum(), (light * y).sum()]) / light.sum()
        of_colour.append(at - wanted)
    return np.array(of_colour), np.array(of_ids)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", LENSES)
def test_markers_are_where_opencv_projects_them(name):
    of_colour, of_ids = offsets(LENSES[name])
    assert np.abs(of_colour.mean(axis=0)).max() < 0.01
    assert np.sqrt((of_colour**2).mean()) < 0.03
    assert np.abs(of_colour).max() < 0.08
    # Ids are whole pixels, through a lens as well.
    assert np.abs(of_ids.mean(axis=0)).max() < 0.02
    assert np.sqrt((of_ids**2).mean()) < 0.05
    assert np.abs(of_ids).max() < 0.13


def test_no_lens_costs_nothing():
    assert lens_of(rig_with(()).left) is None
    check(rig_with(()).left)


@pytest.mark.parametrize("lens", [(-0.9, 0, 0, 0), (-0.30, 0, 0, 0), (0.1, -0.5, 0, 0)])
def test_a_lens_that_folds_the_picture_is_refused(lens):
    for refused in (check, lens_of):
        with pytest.raises(ValueError, match=r"lens distortion \(.*\) is too strong to render"):
            refused(rig_with(lens).left)


@pytest.mark.parametrize("name", ["barrel", "pincushion", "tangential as well"])
def test_the_finer_map_is_the_map_of_finer_pixels(name):
    camera = rig_with(LENSES[name]).left
    fine = finer(ideal_pixels(camera), 2)
    assert fine.shape == (960, 1280, 2)
    y, x = np.mgrid[:960:13, :1280:17]
    real = np.column_stack([x.ravel(), y.ravel()]) / 2 - 0.25
    offset = fine[::13, ::17].reshape(-1, 2) - undistort_points(camera, real)
    assert np.abs(offset).max() < 2e-3


def test_every_pixel_has_a_place_in_the_ideal_picture():
    lens = lens_of(rig_with(LENSES["barrel"]).left)
    height, width = 2 * lens.ideal.height_px, 2 * lens.ideal.width_px
    low, high = lens.colour_map.min(axis=(0, 1)), lens.colour_map.max(axis=(0, 1))
    assert (low >= 0).all()
    assert (high <= [width - 1, height - 1]).all()
    assert 0 <= lens.corners.min() <= lens.corners.max() < width * height
    np.testing.assert_allclose(lens.weights.sum(axis=0), 1.0, atol=1e-12)


BENT = (-0.2, 0.05, 0.001, -0.0008)
COEFFICIENTS = {
    4: BENT,
    5: (*BENT, -0.01),
    8: (*BENT, -0.01, 0.02, -0.01, 0.003),
    12: (*BENT, -0.01, 0.02, -0.01, 0.003, 0.001, -0.002, 0.0015, 0.001),
    14: (*BENT, -0.01, 0.02, -0.01, 0.003, 0.001, -0.002, 0.0015, 0.001, 0.01, -0.02),
}


@pytest.mark.parametrize("count", COEFFICIENTS)
def test_the_lens_is_opencvs(count):
    K = np.array([[540.0, 0, 322.0], [0, 531.0, 236.0], [0, 0, 1]])
    camera = Camera(K, np.eye(3), np.zeros(3), 640, 480, np.array(COEFFICIENTS[count]))
    lens = lens_of(camera)
    rng = generator(100, "lens")
    at = rng.uniform((0, 0), (640, 480), (2000, 2)).astype(np.float32)
    x, y = real_pixels(camera, lens, at[:, 0], at[:, 1])
    np.testing.assert_allclose(np.column_stack([x, y]), distort_points(camera, at), atol=5e-4)
    # Beyond the ideal picture nothing is claimed.
    low = K[:2, 2] - lens.ideal.K[:2, 2]
    beyond = np.array([low - 1, low + np.array([lens.ideal.width_px, 0])], np.float32)
    assert np.isnan(real_pixels(camera, lens, beyond[:, 0], beyond[:, 1])).all()
