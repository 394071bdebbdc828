"""Stills: small, plain, undistorted."""

import cv2
import numpy as np

from pjpdaf.frames import StereoFrame
from reports.pictures.stills import VIEW_WIDTH_PX, still


def test_a_still_is_undistorted_and_plain(tools):
    lens = (-0.3, 0.1, 0.0, 0.0)
    cameras = tools.cameras(lens)
    picture = np.full((480, 640, 3), 90, np.uint8)
    webp = still(StereoFrame(0, 0.0, (picture, None)), cameras)
    sheet = cv2.imdecode(np.frombuffer(webp, np.uint8), cv2.IMREAD_COLOR)
    assert sheet.shape == (240, 2 * VIEW_WIDTH_PX, 3)
    assert abs(int(sheet[120, 160, 0]) - 90) < 4
    assert sheet[:, 330:].max() > 200  # says that it is missing
