"""Disparity and matches: against rays, OpenCV's own rectification, and worlds made by hand."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.calibration import rectify
from pjpdaf.camera import StereoRig, distort_points, project, to_camera
from sim.camera.rays import cast
from sim.camera.render import StereoRenderer
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, OUT_OF_FRAME, SEEN
from sim.dataset.labels.stereo import PicturePair, RectifiedPair
from sim.labels import back_project
from sim.person.rest import rest_pose
from sim.randomness import generator
from sim.scene.rig import stereo_rig
from sim.scene.world import build
from sim.specs import Appearance, ObjectSpec, RigSpec, RoomSpec, SceneSpec

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
PARALLEL = RigSpec(tilt_rad=0.28, principal_offset_px=(6.3, -4.2))
BENT = (-0.2, 0.05, 0.001, -0.0008)
RIGS = {
    "parallel": PARALLEL,
    "vergence": replace(PARALLEL, vergence_rad=0.07),
    "lens": replace(PARALLEL, vergence_rad=0.05, distortion=BENT),
    "parallel lens": replace(PARALLEL, principal_offset_px=(0.0, 0.0), distortion=BENT),
    "wide": replace(PARALLEL, baseline_m=0.2, vergence_rad=0.12),
}
PALMS = (0.34, -0.10, 0.95), (0.34, 0.20, 0.77)
SEEDS = range(100, 140)
FEWER = 5  # rays are cast to every fifth pixel


class Filmed:
    """A scene with a raised hand through one rig: the two depths, and matches of both kinds."""

    def __init__(self, rig):
        self.scene = SceneSpec(
            rig=rig, appearance=Appearance(glasses=True), room=RoomSpec(objects=(CAN,))
        )
        self.world = build(self.scene)
        self.rig = self.world.rig
        self.world.place(rest_pose(self.scene.anatomy, palms_m=PALMS))
        self.rectified = RectifiedPair(self.rig, self.world.lenses)
        with StereoRenderer(self.world) as renderer:
            views = [renderer.view(i, colour=False, amodal=False) for i in (0, 1)]
            ideal = [renderer.pinhole(camera) for camera in self.rectified.cameras]
        self.depths = tuple(known(view.depth_m, view.geoms) for view in views)
        self.ideal_depths = tuple(known(*pair) for pair in ideal)
        self.matches = PicturePair(self.rig, self.world.lenses).matches(self.depths)
        self.disparities = self.rectified.matches(self.ideal_depths)


def known(depth_m, geoms):
    return np.where(geoms >= 0, depth_m, np.float32(np.nan))


@pytest.fixture(scope="module", params=RIGS.values(), ids=RIGS)
def filmed(request):
    return Filmed(request.param)


def by_rays(world, camera, points_w):
    """Pixels (n, 2) of points in a view, and their status there by rays cast to them."""
    pixels = distort_points(camera, project(camera, points_w))
    inside = in_frame(pixels, camera)
    _, met_m = cast(world, camera, pixels)
    hidden = met_m < to_camera(camera, points_w)[:, 2] - 1e-3
    return pixels, np.where(inside, np.where(hidden, HIDDEN, SEEN), OUT_OF_FRAME)


def in_frame(pixels, camera):
    size = camera.width_px, camera.height_px
    return ((pixels >= -0.5) & (pixels < np.array(size) - 0.5)).all(axis=1)


@pytest.mark.sample(3)
@pytest.mark.parametrize("view", [0, 1])
def test_pictures_match_where_rays_meet(filmed, view):
    own, other = filmed.rig.cameras[view], filmed.rig.cameras[1 - view]
    depth_m, found = filmed.depths[view], filmed.matches[view]
    np.testing.assert_array_equal(found.status == NO_SURFACE, np.isnan(depth_m))
    ys, xs = (index[::FEWER] for index in np.nonzero(np.isfinite(depth_m)))
    pixels, status = by_rays(filmed.world, other, back_project(own, xs, ys, depth_m[ys, xs]))
    inside = status != OUT_OF_FRAME
    assert inside.mean() > 0.8
    # Of single precision.
    off = np.abs(found.places_px[ys, xs] - pixels)[inside]
    assert off.max() < 2e-3
    wrong = found.status[ys, xs] != status
    print("matches that differ from rays:", wrong.mean())
    assert wrong.mean() < 0.005
    # What is hidden is called seen near edges; hardly ever the other way round.
    assert (wrong & (status == SEEN)).mean() < 2e-4
    called = (found.status[ys, xs] == HIDDEN) & (status == HIDDEN)
    assert called.sum() > 0.85 * (status == HIDDEN).sum()


@pytest.mark.parametrize("view", [0, 1])
def test_the_rectified_pair_matches_where_rays_meet(filmed, view):
    own, other = (filmed.rectified.cameras[i] for i in (view, 1 - view))
    depth_m, found = filmed.ideal_depths[view], filmed.disparities[view]
    ys, xs = (index[::FEWER] for index in np.nonzero(found.status != NO_SURFACE))
    points = back_project(own, xs, ys, depth_m[ys, xs])
    pixels, status = by_rays(filmed.world, other, points)
    # Outside the frame is also what the other's real picture does not reach.
    real = filmed.rig.cameras[1 - view]
    status[~in_frame(distort_points(real, project(real, points)), real)] = OUT_OF_FRAME
    disparity = found.disparity_px[ys, xs]
    moved = xs - pixels[:, 0] if view == 0 else pixels[:, 0] - xs
    np.testing.assert_allclose(disparity, moved, atol=1e-3)
    np.testing.assert_allclose(pixels[:, 1], ys, atol=1e-3)
    assert disparity.min() >= 0
    wrong = found.status[ys, xs] != status
    print("disparities that differ from rays:", wrong.mean())
    assert wrong.mean() < 0.005
    assert (wrong & (status == SEEN)).mean() < 5e-4


def test_disparity_is_of_the_pair_that_opencv_rectifies(filmed):
    """Real pixels of points go through cv2.undistortPoints with R1, P1 and R2, P2."""
    R1, R2, P1, P2, Q, *_ = rectify(filmed.rig)
    found, depth_m = filmed.disparities[0], filmed.ideal_depths[0]
    rng = generator(100, "pixels")
    ys, xs = np.nonzero(found.status == SEEN)
    some = rng.choice(len(xs), 500, replace=False)
    xs, ys = xs[some], ys[some]
    points = back_project(filmed.rectified.cameras[0], xs, ys, depth_m[ys, xs])
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)
    left, right = (
        cv2.undistortPoints(
            distort_points(camera, project(camera, points)).reshape(-1, 1, 2),
            np.array(camera.K),
            np.array(camera.distortion) if len(camera.distortion) else None,
            R=R,
            P=P,
            criteria=criteria,
        ).reshape(-1, 2)
        for camera, R, P in zip(filmed.rig.cameras, (R1, R2), (P1, P2), strict=True)
    )
    np.testing.assert_allclose(left, np.column_stack([xs, ys]), atol=2e-3)
    np.testing.assert_allclose(left[:, 1], right[:, 1], atol=2e-3)
    np.testing.assert_allclose(left[:, 0] - right[:, 0], found.disparity_px[ys, xs], atol=2e-3)
    # And Q leads from disparity back to depth.
    again = cv2.reprojectImageTo3D(found.disparity_px, Q)[ys, xs]
    np.testing.assert_allclose(again[:, 2], depth_m[ys, xs], rtol=1e-5)


def test_a_place_leads_back_to_its_pixel(filmed):
    """Over there the surface is the same, so its own match is this pixel again."""
    first, second = filmed.matches
    ys, xs = np.nonzero(first.status == SEEN)
    there = np.rint(first.places_px[ys, xs]).astype(int)
    there = np.clip(there, 0, np.array(first.status.shape)[::-1] - 1)
    back = second.places_px[there[:, 1], there[:, 0]]
    off = np.abs(back - np.column_stack([xs, ys])).max(axis=1)
    assert (off < 1.0).mean() > 0.97  # half a pixel of rounding, on slanted surfaces more
    assert np.median(off) < 0.5


def test_the_own_views_serve_where_the_rig_is_parallel(filmed):
    name = next(name for name, rig in RIGS.items() if rig is filmed.scene.rig)
    assert filmed.rectified.drawn == (name != "parallel")
    if filmed.rectified.drawn:
        assert not all(covered.all() for covered in filmed.rectified.covered)
        return
    assert all(covered.all() for covered in filmed.rectified.covered)
    for own, ideal in zip(filmed.depths, filmed.ideal_depths, strict=True):
        np.testing.assert_allclose(own, ideal, atol=5e-5)
    for own, ideal in zip(filmed.rectified.matches(filmed.depths), filmed.disparities, strict=True):
        assert np.count_nonzero(own.status != ideal.status) <= 5
        np.testing.assert_allclose(own.disparity_px, ideal.disparity_px, atol=1e-3)


def test_no_label_where_the_rectified_picture_is_black(filmed):
    """A white picture, rectified by OpenCV, is white where there are labels."""
    R1, _, P1, *_ = rectify(filmed.rig)
    left = filmed.rig.left
    lens = np.array(left.distortion) if len(left.distortion) else np.zeros(5)
    size = left.width_px, left.height_px
    maps = cv2.initUndistortRectifyMap(np.array(left.K), lens, R1, P1, size, cv2.CV_32FC1)
    white = cv2.remap(np.full(size[::-1], 255, np.uint8), *maps, cv2.INTER_NEAREST) == 255
    covered = filmed.rectified.covered[0]
    assert np.count_nonzero(white != covered) <= 30
    found = filmed.disparities[0]
    assert np.isnan(found.disparity_px[~covered]).all()
    assert (found.status[~covered] == NO_SURFACE).all()


def flat(z_m, rig):
    """Depths of both views of a wall across the axes of a parallel rig."""
    left = rig.left
    return tuple(np.full((left.height_px, left.width_px), z_m, np.float32) for _ in range(2))


@pytest.mark.parametrize("kind", ["pictures", "rectified"])
def test_a_board_hides_as_much_as_it_moves_more(kind, seed):
    """A board before a wall hides, beside it, the difference of both disparities."""
    rng = generator(seed, "board")
    rig = stereo_rig(RigSpec())
    far, near = rng.uniform(1.5, 4.0), rng.uniform(0.5, 1.2)
    bf = 540 * 0.09
    depths = flat(far, rig)
    wide = int(rng.integers(60, 120))
    at = int(rng.integers(200, 300)) + bf / near  # its left edge in the left view
    for view, depth in enumerate(depths):
        edge = at - view * bf / near
        xs = np.arange(640)
        depth[100:300, (xs >= edge) & (xs < edge + wide)] = near
        depth[5] = np.nan
    make = PicturePair if kind == "pictures" else RectifiedPair
    left, right = make(rig, (None, None)).matches(depths)
    shift = bf / near - bf / far
    for found in (left, right):
        count = (found.status[150] == HIDDEN).sum()
        # Edges lie within a pixel of where they are drawn, and a pixel behind one is seen.
        assert shift - 4 <= count <= shift + 1
        assert (found.status[5] == NO_SURFACE).all()
        assert (found.status[400] == HIDDEN).sum() == 0
        assert (found.status[400] == OUT_OF_FRAME).sum() == pytest.approx(bf / far, abs=1)
    assert (np.flatnonzero(left.status[150] == HIDDEN) < at).all()
    assert (np.flatnonzero(right.status[150] == HIDDEN) > at - bf / near).all()


@pytest.mark.parametrize("kind", ["pictures", "rectified"])
def test_no_plane_hides_itself(kind, seed):
    """However slanted, as long as both cameras are on its same side."""
    rng = generator(seed, "plane")
    rig = stereo_rig(RigSpec())
    tilt = rng.uniform(0, 2 * np.pi)
    slope = rng.uniform(0.0, 8.0)
    nx, ny = slope * np.cos(tilt), slope * np.sin(tilt)  # z = 2 + nx x + ny y
    depths = []
    for camera, x0 in zip(rig.cameras, (-0.045, 0.045), strict=True):
        ys, xs = np.mgrid[:480, :640]
        u, v = (xs - camera.K[0, 2]) / 540, (ys - camera.K[1, 2]) / 540
        z = (2 + nx * x0) / (1 - nx * u - ny * v)
        depths.append(np.where((z > 0.3) & (z < 12), z, np.nan).astype(np.float32))
    make = PicturePair if kind == "pictures" else RectifiedPair
    for found in make(rig, (None, None)).matches(tuple(depths)):
        assert (found.status == SEEN).sum() > 1000
        assert (found.status == HIDDEN).sum() == 0


def test_a_point_behind_the_other_camera_is_out_of_frame():
    rig = stereo_rig(RigSpec(width_px=64, height_px=48, focal_px=54.0))
    turned = replace(
        rig.right, R_cw=-rig.right.R_cw * [[1], [-1], [1]], t_cw=-rig.right.t_cw * [1, -1, 1]
    )
    left, _ = PicturePair(StereoRig(rig.left, turned), (None, None)).matches(
        tuple(np.full((48, 64), 2.0, np.float32) for _ in range(2))
    )
    assert (left.status == OUT_OF_FRAME).all()
    assert np.isnan(left.places_px).all()
