"""What truth.parquet and objects.parquet say, and what of it can be wrong without any picture."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from sim.camera.clock import MOST_OF_PERIOD
from sim.dataset.check.fault import Claim
from sim.dataset.files.layout import OBJECTS, RIG, TRUTH
from sim.dataset.frame_rows import FrameRow, frames_of
from sim.dataset.labels.records import KEYPOINTS
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.truth import Truth

FAR_M = 0.35  # from a target's centre to its visible surface, at most
_CENTRES = [KEYPOINTS.index((t, "palm_centre" if t else "head_centre")) for t in range(3)]


@dataclass(frozen=True, eq=False)
class FrameTables:
    """A frame's rows. truth: the record of them; rows: per target; objects: per object.

    keypoints_m (K, 3); per view keypoints_px (K, 2) and keypoint_status (K,).
    """

    truth: Truth
    rows: tuple[FrameRow, ...]
    objects: tuple[FrameRow, ...]
    keypoints_m: Floats
    keypoints_px: tuple[Floats, ...]
    keypoint_status: tuple[NDArray[np.int64], ...]

    @property
    def arrived(self) -> tuple[bool, ...]:
        """Per view, whether its picture arrived."""
        return tuple(bool(self.rows[0][f"arrived_{camera}"]) for camera in CAMERAS)


def read_frames(sequence: StoredSequence) -> list[FrameTables]:
    """All frames. Raises BenchError that names the table where one is damaged."""
    truths, frames = sequence.truths, frames_of(sequence)
    names = _object_names(sequence)
    found = []
    for i, (truth, frame) in enumerate(zip(truths, frames, strict=True)):
        if [row["object"] for row in frame.objects] != names:
            raise BenchError(
                f"{sequence.folder / OBJECTS}: frame {i}: must have a row for each object of "
                f"{RIG}, in order."
            )
        rows = frame.targets
        hidden = (one for row in rows for c in CAMERAS for one in row[f"occluded_by_{c}"])
        if any(one is None or None in (one["instance"], one["pixels"]) for one in hidden):
            raise BenchError(f"{sequence.folder / TRUTH}: frame {i}: occluded_by lacks values.")
        found.append(
            FrameTables(
                truth,
                rows,
                frame.objects,
                _points(rows, "keypoints_m", 3),
                tuple(_points(rows, f"keypoints_{camera}_px", 2) for camera in CAMERAS),
                tuple(_statuses(rows, f"keypoint_status_{camera}") for camera in CAMERAS),
            )
        )
    return found


@dataclass(frozen=True, eq=False)
class Numbers:
    """What exports repeat of a sequence of F frames and O objects. size_px: width, height.

    arrived (F, 2), stamps_s (F,), centres_m (F, T, 3); per view: visible_px, amodal_px, fractions
    (2, F, T), boxes_px (2, F, T, 4), centroids_px (2, F, T, 2), objects_px (2, F, O) of the
    objects with these ids.
    """

    name: str
    fps: float
    size_px: tuple[int, int]
    object_ids: tuple[int, ...]
    arrived: NDArray[np.bool_]
    stamps_s: Floats
    centres_m: Floats
    visible_px: NDArray[np.int64]
    amodal_px: NDArray[np.int64]
    fractions: Floats
    boxes_px: Floats
    centroids_px: Floats
    objects_px: NDArray[np.int64]


def numbers_of(sequence: StoredSequence, told: list[FrameTables]) -> Numbers:
    """The numbers of its rows."""
    views = [[frame.truth.views[v] for frame in told] for v in range(len(CAMERAS))]
    ids = tuple(one.id for one in sequence.instances if one.kind == "object")
    objects = [
        [[row[f"visible_{camera}_px"] for row in frame.objects] for frame in told]
        for camera in CAMERAS
    ]
    camera = sequence.rig.left
    return Numbers(
        name=sequence.name,
        fps=sequence.fps,
        size_px=(camera.width_px, camera.height_px),
        object_ids=ids,
        arrived=np.array([frame.arrived for frame in told]),
        stamps_s=np.array([frame.rows[0]["stamp_s"] for frame in told]),
        centres_m=np.array([frame.truth.centres_m for frame in told]),
        visible_px=np.array([[one.visible_px for one in view] for view in views]),
        amodal_px=np.array([[one.amodal_px for one in view] for view in views]),
        fractions=np.array([[one.visible_fractions for one in view] for view in views]),
        boxes_px=np.array([[one.boxes_px for one in view] for view in views]),
        centroids_px=np.array([[one.centroids_px for one in view] for view in views]),
        objects_px=np.array(objects, np.int64).reshape(len(CAMERAS), len(told), len(ids)),
    )


def time_claims(name: str, told: list[FrameTables], fps: float) -> Iterator[Claim]:
    """Times, stamps, and what must be the same in all rows of a frame."""
    file, last_s = f"{name}/{TRUTH}", -math.inf
    common = ("time_s", "stamp_s", "arrived_left", "arrived_right", "events")
    for i, frame in enumerate(told):
        first = frame.rows[0]
        time_s, stamp_s, nominal_s = frame.truth.time_s, first["stamp_s"], i / fps
        if any(row[key] != first[key] for row in frame.rows for key in common):
            yield Claim(file, "rows of a frame", i, f"differ in one of {', '.join(common)}")
        if not abs(time_s - nominal_s) <= MOST_OF_PERIOD / fps + 1e-9 or not time_s > last_s:
            yield Claim(file, "time_s", i, f"is {time_s:.6g} s, {fps:g} frames a second are said")
        if stamp_s not in (time_s, nominal_s):
            yield Claim(file, "stamp_s", i, f"{stamp_s} s is neither time_s nor index / fps")
        last_s = time_s
        for row in frame.objects:
            if row["time_s"] != time_s:
                yield Claim(f"{name}/{OBJECTS}", "time_s", i, "is not that of truth.parquet")


def shape_claims(name: str, told: list[FrameTables]) -> Iterator[Claim]:
    """Rotations, centres, surfaces, fractions."""
    file = f"{name}/{TRUTH}"
    for i, frame in enumerate(told):
        truth = frame.truth
        off_m = np.abs(frame.keypoints_m[_CENTRES] - truth.centres_m).max()
        if not off_m <= 1e-9:
            yield Claim(file, "keypoints_m", i, f"centres lie {off_m:.3g} m from x_m, y_m, z_m")
        tables = ((file, "target", frame.rows), (f"{name}/{OBJECTS}", "object", frame.objects))
        for table, key, rows in tables:
            for row in rows:
                length = math.sqrt(sum((row[q] or 0.0) ** 2 for q in ("qw", "qx", "qy", "qz")))
                if not abs(length - 1) <= 1e-9:
                    kind = f"quaternion of {row[key]}"
                    yield Claim(table, kind, i, f"has the length {length:.6g}")
        for t, target in enumerate(TARGETS):
            seen = any(view.visible_px[t] > 0 for view in truth.views)
            far_m = np.linalg.norm(truth.surfaces_m[t] - truth.centres_m[t])
            if seen != bool(np.isfinite(far_m)) or far_m > FAR_M:
                what = f"is {far_m:.3g} m from the centre, its visible pixels say otherwise"
                yield Claim(file, f"surface of {target}", i, what)
            for camera, view in zip(CAMERAS, truth.views, strict=True):
                fraction = frame.rows[t][f"visible_fraction_{camera}"]
                wanted = view.visible_fractions[t]
                if fraction != wanted or not wanted <= 1:
                    kind = f"visible_fraction of {target}, {camera} view"
                    yield Claim(file, kind, i, f"is {fraction}, visible / amodal is {wanted:.6g}")


def _object_names(sequence: StoredSequence) -> list[str]:
    """Names of the objects of rig.json, in order."""
    return [one.name for one in sequence.instances if one.kind == "object"]


def _points(rows: tuple[FrameRow, ...], key: str, size: int) -> Floats:
    points = [point for row in rows for point in row[key]]
    array = np.array([[np.nan if v is None else v for v in p] for p in points], np.float64)
    assert array.shape == (len(KEYPOINTS), size), "frames_of has checked it"
    return array


def _statuses(rows: tuple[FrameRow, ...], key: str) -> NDArray[np.int64]:
    return np.array([value for row in rows for value in row[key]], np.int64)
