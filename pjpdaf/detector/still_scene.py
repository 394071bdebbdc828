"""What the first person-free frames say of the cameras: each view's noise, and how they stand."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import NamedTuple

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.detector.alignment import Alignment, align
from pjpdaf.detector.exposure import Exposure, exposure_of
from pjpdaf.frames import StereoFrame

SCENE_FRAMES = 10  # of the background


class StillScene(NamedTuple):
    """Smoothing of each view's pictures; rotation of the second view, None for none."""

    exposures: tuple[Exposure, ...]
    alignment: Alignment | None


def still_scene(
    background: Iterable[StereoFrame],
    cameras: tuple[Camera, ...],
    *,
    smooth_noise: bool,
    align_views: bool,
) -> StillScene:
    """Look at the first SCENE_FRAMES frames without a person.

    smooth_noise, align_views: without these no picture is smoothed, and no rotation is looked for.
    """
    frames = list(islice(background, SCENE_FRAMES))
    views = [
        [p for f in frames if (p := f.pictures[view]) is not None] for view in range(len(cameras))
    ]
    exposures = tuple(exposure_of(view) if smooth_noise else Exposure() for view in views)
    return StillScene(exposures, _alignment(views, cameras) if align_views else None)


def _alignment(views: list[list[np.ndarray]], cameras: tuple[Camera, ...]) -> Alignment | None:
    """Alignment of the views of a still scene, None where there is none to take out."""
    if len(cameras) != 2 or not all(views):
        return None
    one, two = (np.rint(_mean(view)).astype(np.uint8) for view in views)
    found = align((one, two), (cameras[0], cameras[1]))
    return found if found is not None and found.matters else None


def _mean(pictures: list[np.ndarray]) -> Floats:
    """Mean of uint8 pictures; the sums are exact."""
    total = np.zeros(pictures[0].shape)
    for picture in pictures:
        cv2.accumulate(picture, total)
    return total / len(pictures)
