from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import project
from sim.scene.rig import stereo_rig
from sim.silhouettes.outlines import outlines_of, paint
from sim.silhouettes.shapes import CLOTHED, TARGET_PAINT, Bars, Hull
from sim.specs import RigSpec

CAMERA = stereo_rig(RigSpec(tilt_rad=0.0, baseline_m=0.001)).left
FOCAL_PX, DISTANCE_M, HEIGHT_M = 540.0, 1.30, 1.35


def ball(x_m, y_m, z_m, radius_m, shade):
    centre = np.array([[[x_m, y_m, z_m]]])
    radius = np.array([radius_m])
    return Bars(centre, centre, radius, radius, np.array([shade], np.uint8))


def both(a, b):
    return Bars(
        np.concatenate([a.starts_m, b.starts_m], axis=1),
        np.concatenate([a.ends_m, b.ends_m], axis=1),
        np.concatenate([a.start_radii_m, b.start_radii_m]),
        np.concatenate([a.end_radii_m, b.end_radii_m]),
        np.concatenate([a.paints, b.paints]),
    )


def painted(bars, hulls=(), step_px=1):
    outlines = outlines_of(bars, list(hulls), CAMERA, step_px)
    canvas = np.zeros(outlines.size, np.uint8)
    paint(outlines, 0, canvas)
    return canvas


@pytest.mark.parametrize("step_px", [1, 2, 4])
def test_a_ball_is_a_disc_where_the_camera_sees_it(step_px):
    canvas = painted(ball(0.30, 0.10, 1.25, 0.05, TARGET_PAINT), step_px=step_px)
    ys, xs = np.nonzero(canvas)
    centre = np.array([xs.mean(), ys.mean()]) * step_px + (step_px - 1) / 2
    # 1 m away, so that 0.1 m are 54 px; the person's left is on the right of the picture.
    expected = project(CAMERA, np.array([0.30, 0.10, 1.25]))
    np.testing.assert_allclose(expected, [373.5, 293.5], atol=0.5)
    np.testing.assert_allclose(centre, expected, atol=0.25 * step_px)
    assert len(xs) * step_px**2 == pytest.approx(np.pi * (0.05 * FOCAL_PX) ** 2, rel=0.03)


def test_a_thin_bar_keeps_its_area_in_a_reduced_picture():
    start, end = np.array([[[0.30, -0.05, 1.30]]]), np.array([[[0.30, 0.05, 1.33]]])
    finger = Bars(start, end, np.array([0.008]), np.array([0.008]), np.array([4], np.uint8))
    length = FOCAL_PX * np.hypot(0.10, 0.03)
    r = FOCAL_PX * 0.008
    for step_px in (1, 4):
        area = np.count_nonzero(painted(finger, step_px=step_px)) * step_px**2
        assert area == pytest.approx(2 * r * length + np.pi * r * r, rel=0.08)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_shape_covers_the_farther_whatever_their_order(order):
    near = ball(0.40, 0.0, HEIGHT_M, 0.03, TARGET_PAINT)
    far = ball(0.20, 0.0, HEIGHT_M, 0.06, TARGET_PAINT + 1)
    canvas = painted(both(*((near, far)[i] for i in order)))
    assert canvas[240, 320] == TARGET_PAINT
    assert set(np.unique(canvas)) == {0, TARGET_PAINT, TARGET_PAINT + 1}
    hidden = replace(near, start_radii_m=np.array([0.07]), end_radii_m=np.array([0.07]))
    assert TARGET_PAINT + 1 not in painted(both(far, hidden))


def test_a_board_covers_what_is_below_it_and_not_what_lies_on_it():
    low, high = np.array([0.20, -0.10, 1.10]), np.array([0.50, 0.10, 1.11])
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    points = (low + corners * (high - low))[None]
    board = Hull(points, CLOTHED, normals=np.array([[0.0, 0.0, 1.0]]))
    # Nearer to the camera than the board's middle although below it, and the reverse.
    below = ball(0.37, 0.0, 1.09, 0.008, TARGET_PAINT)
    above = ball(0.24, 0.0, 1.13, 0.015, TARGET_PAINT + 1)
    shades = set(np.unique(painted(both(below, above), [board])))
    assert shades == {0, CLOTHED, TARGET_PAINT + 1}


def test_what_is_behind_the_camera_is_not_painted():
    assert not painted(ball(1.60, 0.0, HEIGHT_M, 0.05, TARGET_PAINT)).any()
