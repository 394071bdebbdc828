"""The numbers of a sequence that COCO's and MOTChallenge's files repeat."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD, TARGETS
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED, SKELETON_SLICES
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS


@dataclass(frozen=True, eq=False)
class SequenceNumbers:
    """Numbers of a sequence of F frames and O objects that exports repeat. size_px: width, height.

    arrived (F, 2), stamps_s (F,), centres_m (F, T, 3); per view: visible_px, fractions
    (2, F, T), boxes_px (2, F, T, 4), centroids_px (2, F, T, 2), objects_px (2, F, O) of the
    objects with these ids; points by skeleton, and of the head: u, v, status (2, F, K, 3), of
    points outside the picture all 0.
    """

    name: str
    fps: float
    size_px: tuple[int, int]
    object_ids: tuple[int, ...]
    arrived: NDArray[np.bool_]
    stamps_s: Floats
    centres_m: Floats
    visible_px: NDArray[np.int64]
    fractions: Floats
    boxes_px: Floats
    centroids_px: Floats
    objects_px: NDArray[np.int64]
    points: Mapping[str, Floats]


def numbers_of(sequence: StoredSequence, tables: list[FrameTables]) -> SequenceNumbers:
    """Collect the numbers of a sequence's rows."""
    views = [[frame.truth.views[v] for frame in tables] for v in range(len(CAMERAS))]
    ids = tuple(instance.id for instance in sequence.instances if instance.kind == "object")
    objects = [
        [[row[f"visible_{camera}_px"] for row in frame.objects] for frame in tables]
        for camera in CAMERAS
    ]
    camera = sequence.rig.left
    return SequenceNumbers(
        name=sequence.name,
        fps=sequence.fps,
        size_px=(camera.width_px, camera.height_px),
        object_ids=ids,
        arrived=np.array([frame.arrived for frame in tables]),
        stamps_s=np.array([frame.rows[0]["stamp_s"] for frame in tables]),
        centres_m=np.array([frame.truth.centres_m for frame in tables]),
        visible_px=np.array([[truth.visible_px for truth in view] for view in views]),
        fractions=np.array([[truth.visible_fractions for truth in view] for view in views]),
        boxes_px=np.array([[truth.boxes_px for truth in view] for view in views]),
        centroids_px=np.array([[truth.centroids_px for truth in view] for view in views]),
        objects_px=np.array(objects, np.int64).reshape(len(CAMERAS), len(tables), len(ids)),
        points=_points(tables),
    )


def _points(tables: list[FrameTables]) -> dict[str, Floats]:
    """`SequenceNumbers.points`."""
    views = range(len(CAMERAS))
    keypoints = _triples(
        np.array([[frame.keypoints_px[v] for frame in tables] for v in views]),
        np.array([[frame.keypoint_status[v] for frame in tables] for v in views]),
    )
    skeletons = _triples(
        np.array([[frame.skeleton_px[v] for frame in tables] for v in views]),
        np.array([[frame.skeleton_status[v] for frame in tables] for v in views]),
    )
    points = {TARGETS[HEAD]: keypoints[:, :, [t == HEAD for t, _ in KEYPOINTS]]}
    return points | {name: skeletons[:, :, own] for name, own in SKELETON_SLICES.items()}


def _triples(pixels: Floats, status: NDArray[np.int64]) -> Floats:
    triples = np.concatenate([pixels, status[..., None]], axis=-1)
    triples[status == NOT_LABELLED] = 0
    return np.asarray(triples)
