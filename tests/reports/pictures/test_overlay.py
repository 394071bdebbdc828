"""What is drawn lies where the camera sees it."""

import dataclasses

import cv2
import numpy as np
import pytest

from pjpdaf.camera import distort_points, project
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Estimates
from reports.pictures.overlay import overlay_jpeg

GREY = np.full((480, 640, 3), 128, np.uint8)


def draw(pictures, cameras, outcome, **options):
    frame = StereoFrame(outcome.truth.index, outcome.truth.time_s, tuple(pictures))
    seen, said = outcome.detections, outcome.estimates
    return overlay_jpeg(frame, cameras, seen, said, outcome.truth, **options)


def decode(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).astype(int)


@pytest.mark.parametrize("distortion", [(), (-0.3, 0.1, 0.0, 0.0, 0.0)])
def test_circles_lie_about_the_projected_estimates(episode_of, tools, distortion):
    cameras = tools.cameras(distortion)
    centres = tools.paths(1, 3.0)
    centres[0, 1:, 1] *= 2.2  # near the edge, where the lens bends by 15-25 px
    outcome = episode_of(frames=1, centres_m=centres, cameras=cameras).frames[0]
    sheet = decode(draw([GREY, GREY], cameras, outcome))
    assert sheet.shape == (510, 1284, 3)
    for v, camera in enumerate(cameras):
        points = distort_points(camera, project(camera, centres[0]))
        for point, strongest in zip(points, (2, 1, 0), strict=True):  # red, green, blue in BGR
            x, y = np.round(point).astype(int) + np.array([v * 644, 0])
            on_circle = sheet[y, x - 15]
            assert int(np.argmax(on_circle)) == strongest
            assert (abs(sheet[y + 50, x] - 128) < 20).all()  # well outside of it: the picture


def test_waiting_missing_and_behind(episode_of, tools):
    cameras = tools.cameras()
    outcome = episode_of(frames=1, centres_m=tools.paths(1, 3.0)).frames[0]
    waiting = dataclasses.replace(outcome, estimates=Estimates.waiting(), detections=())
    assert decode(draw([None, GREY], cameras, waiting)).shape == (510, 1284, 3)
    said = outcome.estimates
    behind = dataclasses.replace(said, positions_m=said.positions_m + np.array([50.0, 0, 0]))
    draw([GREY, GREY], cameras, dataclasses.replace(outcome, estimates=behind))
    draw([GREY, GREY], cameras, outcome, covariances=True)


def test_the_pictures_given_are_not_drawn_into(episode_of, tools):
    outcome = episode_of(frames=1, centres_m=tools.paths(1, 3.0)).frames[0]
    picture = GREY.copy()
    draw([picture, picture], tools.cameras(), outcome)
    assert (picture == 128).all()


def test_small_pictures(episode_of, tools):
    cameras = tuple(
        dataclasses.replace(c, width_px=320, height_px=240, K=np.diag([0.5, 0.5, 1]) @ c.K)
        for c in tools.cameras()
    )
    outcome = episode_of(frames=1, centres_m=tools.paths(1, 3.0), cameras=cameras).frames[0]
    small = np.zeros((240, 320, 3), np.uint8)
    assert decode(draw([small, small], cameras, outcome)).shape == (270, 644, 3)
