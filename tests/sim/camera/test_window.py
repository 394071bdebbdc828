from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import project
from sim.camera.window import Window, around, joined, whole
from sim.scene.rig import stereo_rig
from sim.specs import RigSpec

CAMERA = stereo_rig(RigSpec(tilt_rad=0.28, vergence_rad=0.1)).left
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def box(depth_m, at=(0.0, 0.0), half_m=0.05):
    """Corners of a box in the world, so far before the camera, at so many metres to right, down."""
    centre = np.array([at[0], at[1], depth_m])
    return (centre + half_m * CORNERS - CAMERA.t_cw) @ CAMERA.R_cw


def test_a_window_holds_all_points_of_its_boxes():
    rng = np.random.default_rng(3)
    for _ in range(30):
        corners = np.stack([box(rng.uniform(0.4, 3.0), rng.uniform(-1, 1, 2)) for _ in range(3)])
        weights = rng.dirichlet(np.ones(8), size=(3, 200))
        pixels = project(CAMERA, (weights @ corners).reshape(-1, 3))
        seen = pixels[((pixels > -0.5) & (pixels < [639.5, 479.5])).all(axis=1)]
        pixels = np.rint(seen).astype(int)
        window = around(CAMERA, corners)
        assert (pixels >= [window.left, window.top]).all()
        assert (pixels < [window.right, window.bottom]).all()
        assert window == window.within(640, 480)


def test_boxes_behind_the_camera_or_beside_the_picture_are_not_seen():
    assert around(CAMERA, box(-1.0)[None]).empty
    assert around(CAMERA, box(1.0, (5.0, 0.0))[None]).empty
    assert around(CAMERA, np.empty((0, 8, 3))).empty


def test_a_box_through_the_cameras_plane_may_be_seen_anywhere():
    assert around(CAMERA, box(0.02)[None]) == whole(CAMERA)


def test_the_camera_of_a_window_sees_that_part_of_the_picture():
    window = Window(100, 40, 420, 300)
    part = window.crop(CAMERA)
    assert (part.width_px, part.height_px) == (320, 260)
    points = box(1.2)
    np.testing.assert_allclose(project(part, points), project(CAMERA, points) - [100, 40])


def test_parts_of_finer_pictures_and_of_pictures_from_below():
    ys, xs = np.mgrid[:480, :640]
    window = Window(100, 40, 420, 300)
    rows, columns = window.part(1)
    assert (ys[rows, columns].min(), ys[rows, columns].max()) == (40, 299)
    assert (xs[rows, columns].min(), xs[rows, columns].max()) == (100, 419)
    rows, columns = window.part(2, from_below=960)
    from_above = np.repeat(ys, 2, axis=0)[::-1][rows]
    assert (from_above.min(), from_above.max(), columns) == (40, 299, slice(200, 840))


@pytest.mark.parametrize("empty", [Window(0, 0, 0, 0), Window(5, 3, 5, 9)])
def test_an_empty_window_adds_nothing(empty):
    window = Window(10, 20, 30, 40)
    assert joined(window, empty) == joined(empty, window) == window
    assert joined(window, replace(window, left=2, bottom=99)) == Window(2, 20, 30, 99)
    assert empty.empty
    assert not window.empty
