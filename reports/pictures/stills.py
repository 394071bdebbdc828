"""A frame's two views as one small plain picture: the page's player draws upon it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pjpdaf.camera import Camera, undistort_picture
from pjpdaf.frames import StereoFrame
from reports.pictures.encode import webp_of
from reports.pictures.overlay import canvas_of

VIEW_WIDTH_PX = 320
QUALITY = 32  # of WebP; about 6 kB a frame of two views


def still(frame: StereoFrame, cameras: Sequence[Camera]) -> bytes:
    """Encode all views of a frame side by side, each `VIEW_WIDTH_PX` wide, as WebP.

    Undistorted, so that detections and projections lie on it as they are. Nothing is drawn in; a
    missing picture is grey with a note.
    """
    views = []
    for picture, camera in zip(frame.pictures, cameras, strict=True):
        ideal = undistort_picture(camera, canvas_of(picture, camera))
        height = round(VIEW_WIDTH_PX * camera.height_px / camera.width_px)
        views.append(cv2.resize(ideal, (VIEW_WIDTH_PX, height), interpolation=cv2.INTER_AREA))
    height = max(len(view) for view in views)
    padded = [np.pad(view, ((0, height - len(view)), (0, 0), (0, 0))) for view in views]
    return webp_of(np.hstack(padded), QUALITY)
