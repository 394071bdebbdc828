"""Rectified pairs with disparity as PFM, in the folders of Middlebury's stereo evaluation.

A folder a frame: im0.png and im1.png, rectified; disp0.pfm and disp1.pfm, float32, little endian,
infinite where there is none (SceneFlow's files have the same form); mask0nocc.png and
mask1nocc.png: 255 seen in both pictures, 128 in one, 0 no disparity; calib.txt.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Image
from pjpdaf.calibration import rectify
from pjpdaf.camera import StereoRig
from sim.dataset.export.export import Export
from sim.dataset.files import encode
from sim.dataset.files.layout import picture_name
from sim.dataset.frame_rows import read_frame_rows
from sim.dataset.labels.records import SEEN, Matches
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import step

BOTH, ONE, NONE = 255, 128, 0  # of the masks


def write_middlebury(sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write a folder a frame whose both pictures arrived."""
    maps = _maps(sequence.rig)
    for frame in read_frame_rows(sequence):
        if all(frame.arrived.values()):
            index = frame.index
            into = part / f"{sequence.name}_{picture_name(index, '')}"
            into.mkdir()
            matches = [sequence.rectified(view, index) for view in (0, 1)]
            for view, (camera, own) in enumerate(zip(CAMERAS, matches, strict=True)):
                picture = sequence.picture(camera, index, np.uint8, 3)
                _write_view(into, view, cv2.remap(picture, *maps[view], cv2.INTER_LINEAR), own)
            most = max(_most_px(own) for own in matches)
            (into / "calib.txt").write_text(calib_text(sequence.rig, most), "ascii")
        step()


export = Export("middlebury", "middlebury", "Middlebury's files", write_middlebury)


def _most_px(matches: Matches) -> float:
    assert matches.disparity_px is not None, "a rectified pair always has a disparity"
    return float(np.nanmax(matches.disparity_px, initial=0.0))


def pfm(values: NDArray[np.float32]) -> bytes:
    """A picture (h, w) of float32 as PFM: little endian, rows from below."""
    height, width = values.shape
    head = f"Pf\n{width} {height}\n-1.0\n".encode("ascii")
    return head + np.ascontiguousarray(values[::-1], "<f4").tobytes()


def calib_text(rig: StereoRig, most_px: float) -> str:
    """Content of calib.txt: baseline in millimetres, the rest in pixels.

    depth = baseline f / (disparity + doffs). ndisp: above most_px, the greatest disparity.
    """
    _, _, P1, P2, *_ = rectify(rig)
    f = float(P1[0, 0])

    def matrix(P: NDArray[np.float64]) -> str:
        return f"[{f!r} 0 {float(P[0, 2])!r}; 0 {f!r} {float(P[1, 2])!r}; 0 0 1]"

    lines = {
        "cam0": matrix(P1),
        "cam1": matrix(P2),
        "doffs": repr(float(P2[0, 2] - P1[0, 2])),
        "baseline": repr(-1e3 * float(P2[0, 3]) / f),
        "width": str(rig.left.width_px),
        "height": str(rig.left.height_px),
        "ndisp": str(int(most_px) + 2),
    }
    return "".join(f"{key}={value}\n" for key, value in lines.items())


def _maps(rig: StereoRig) -> list[tuple[Image, Image]]:
    """Per view, the maps of cv2.remap to the rectified picture."""
    R1, R2, P1, P2, *_ = rectify(rig)
    maps = []
    for camera, R, P in zip(rig.cameras, (R1, R2), (P1, P2), strict=True):
        size = camera.width_px, camera.height_px
        own = np.array(camera.distortion) if len(camera.distortion) else np.zeros(5)
        x, y = cv2.initUndistortRectifyMap(np.array(camera.K), own, R, P[:, :3], size, cv2.CV_32FC1)
        maps.append((x, y))
    return maps


def _write_view(folder: Path, view: int, picture: Image, matches: Matches) -> None:
    assert matches.disparity_px is not None, "a rectified pair always has a disparity"
    known = np.isfinite(matches.disparity_px)
    disparity = np.where(known, matches.disparity_px, np.float32(np.inf))
    mask = np.where(known, np.where(matches.status == SEEN, BOTH, ONE), NONE).astype(np.uint8)
    (folder / f"im{view}.png").write_bytes(encode.png(picture))
    (folder / f"disp{view}.pfm").write_bytes(pfm(disparity))
    (folder / f"mask{view}nocc.png").write_bytes(encode.png(mask))
