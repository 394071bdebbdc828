"""The tables of a sequence, a record per frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats
from pjpdaf.errors import FileError
from sim.dataset.files.layout import OBJECTS, RIG, TRUTH
from sim.dataset.frame_rows import FrameRow, read_frame_rows
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.truth import Truth


@dataclass(frozen=True, eq=False)
class FrameTables:
    """The rows of a frame. rows: per target; truth: their record; objects: rows per object.

    keypoints_m (K, 3); per view keypoints_px (K, 2) and keypoint_status (K,); the same of the
    P points of skeletons.parquet. finger_angles_rad (2, 5, 3).
    """

    truth: Truth
    rows: tuple[FrameRow, ...]
    objects: tuple[FrameRow, ...]
    keypoints_m: Floats
    keypoints_px: tuple[Floats, ...]
    keypoint_status: tuple[NDArray[np.int64], ...]
    skeleton_m: Floats
    skeleton_px: tuple[Floats, ...]
    skeleton_status: tuple[NDArray[np.int64], ...]
    finger_angles_rad: Floats

    @property
    def arrived(self) -> tuple[bool, ...]:
        """Per view, whether its picture arrived."""
        return tuple(bool(self.rows[0][f"arrived_{camera}"]) for camera in CAMERAS)


def read_frames(sequence: StoredSequence) -> list[FrameTables]:
    """Read the tables of all frames. Raises FileError naming a damaged table."""
    truths, frames = sequence.truths, read_frame_rows(sequence)
    names = [instance.name for instance in sequence.instances if instance.kind == "object"]
    tables = []
    for i, (truth, frame) in enumerate(zip(truths, frames, strict=True)):
        if [row["object"] for row in frame.objects] != names:
            raise FileError(
                sequence.folder / OBJECTS,
                f"frame {i}: must have a row for each object of {RIG}, in order",
            )
        rows = frame.targets
        occluders = (by for row in rows for c in CAMERAS for by in row[f"occluded_by_{c}"])
        if any(by is None or None in (by["instance"], by["pixels"]) for by in occluders):
            raise FileError(sequence.folder / TRUTH, f"frame {i}: occluded_by lacks values")
        tables.append(
            FrameTables(
                truth,
                rows,
                frame.objects,
                _points(rows, "keypoints_m", 3),
                tuple(_points(rows, f"keypoints_{camera}_px", 2) for camera in CAMERAS),
                tuple(_statuses(rows, f"keypoint_status_{camera}") for camera in CAMERAS),
                _points(frame.skeletons, "points_m", 3),
                tuple(_points(frame.skeletons, f"points_{camera}_px", 2) for camera in CAMERAS),
                tuple(_statuses(frame.skeletons, f"point_status_{camera}") for camera in CAMERAS),
                np.array([row["finger_angles_rad"] for row in frame.skeletons[1:]], np.float64),
            )
        )
    return tables


def _points(rows: tuple[FrameRow, ...], key: str, size: int) -> Floats:
    points = [point for row in rows for point in row[key]]
    array = np.array([[np.nan if v is None else v for v in p] for p in points], np.float64)
    assert array.shape == (len(points), size), "read_frame_rows has checked it"
    return array


def _statuses(rows: tuple[FrameRow, ...], key: str) -> NDArray[np.int64]:
    return np.array([value for row in rows for value in row[key]], np.int64)


def rotation_of(row: FrameRow) -> Rotation:
    """The rotation of a target or an object from its own frame to the world."""
    return Rotation.from_quat([row[q] for q in ("qw", "qx", "qy", "qz")], scalar_first=True)
