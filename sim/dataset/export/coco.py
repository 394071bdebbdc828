"""COCO's instances files, one per view: masks, boxes, keypoints, and other labels in own fields.

A picture that did not arrive has no entry. A target or object that no pixel shows has no
annotation, because COCO's readers expect every annotation to be detected; the image's field
`hidden_targets` has the hidden targets instead.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.coco_file import CocoFile, CocoRecords, RunLengths
from sim.dataset.export.coco_ids import (
    FIRST_OBJECT_CATEGORY,
    INSTANCES,
    OBJECT_KINDS,
    PERSON_CATEGORY,
    categories,
    image_id,
    pair_id,
)
from sim.dataset.export.export import AddPart, Export
from sim.dataset.files.layout import RIG, SCHEMA_VERSION, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, object_kinds, read_frame_rows
from sim.dataset.labels.instances import NOTHING, PERSON
from sim.dataset.labels.records import BODY_POINTS, BODY_SKELETON, COCO_BODY, NOT_LABELLED
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import step

LICENCE = {
    "id": 1,
    "name": "Creative Commons Attribution 4.0 International (CC BY 4.0)",
    "url": "https://creativecommons.org/licenses/by/4.0/",
}
_OF_PERSON = set(range(NOTHING + 1, PERSON + 1))  # ids of the person, head and hands
_PX, _M, _SHARE = 3, 6, 6  # decimals: 0.001 px, 1 um; truth.parquet has all of them


def write_coco(sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write the records of both views; with amodal masks where there is the label `amodal`."""
    run_lengths = RunLengths()
    frames = read_frame_rows(sequence)
    for view, camera in enumerate(CAMERAS):
        with ExitStack() as stack:
            records = _ViewRecords(sequence, view, "amodal" in labels, run_lengths)
            records.write(frames, CocoRecords(part, camera, stack))


@contextmanager
def _joining(dataset: Dataset, folder: Path) -> Iterator[AddPart]:
    """Write `instances_left.json` and `instances_right.json`."""

    def add(sequence: StoredSequence, part: Path) -> None:
        for camera, file in files.items():
            file.add(part, camera)

    with ExitStack() as stack:
        files = {
            camera: CocoFile(folder / f"instances_{camera}.json", _head(camera), stack)
            for camera in CAMERAS
        }
        yield add
        for file in files.values():
            file.finish()


export = Export("coco", "annotations", "COCO's files", write_coco, _joining, "pycocotools.mask")


def _head(camera: str) -> dict[str, Any]:
    # No year and no date: the same data set gives the same bytes on any day.
    info = {
        "description": f"Stereo pictures of a seated person's head and hands, {camera} "
        "view, rendered with exact labels",
        "version": f"{SCHEMA_VERSION}",
        "contributor": "The pjpdaf-bench authors",
        "url": "",
    }
    return {"info": info, "licenses": [LICENCE], "categories": categories()}


class _ViewRecords:
    """Images and annotations of one view of a sequence."""

    def __init__(
        self, sequence: StoredSequence, view: int, amodal: bool, run_lengths: RunLengths
    ) -> None:
        self._sequence, self._view, self._camera = sequence, view, CAMERAS[view]
        self._amodal, self._run_lengths = amodal, run_lengths
        self._size = sequence.rig.cameras[view]
        self._ids = {
            instance.name: instance.id
            for instance in sequence.instances
            if instance.kind == "object"
        }
        self._kinds = object_kinds(sequence)

    def write(self, frames: list[FrameRows], file: CocoRecords) -> None:
        """Write the images of the pictures that arrived, and their annotations."""
        for frame in frames:
            if frame.arrived[self._camera]:
                self._frame(file, frame)
            if self._view == 1:  # the last; the frame is done
                step()

    def _frame(self, file: CocoRecords, frame: FrameRows) -> None:
        seg = self._sequence.seg(self._view, frame.index)
        ids = set(np.flatnonzero(np.bincount(seg.ravel())).tolist())
        visible: list[tuple[int, dict[str, Any]]] = []
        hidden = []
        # Of the head its own two keypoints, of a hand its joints.
        _, *hands = frame.skeletons
        for (number, row), skeleton, amodal in zip(
            enumerate(frame.targets, 1),
            (None, *hands),
            self._amodal_fields(frame.index),
            strict=True,
        ):
            points = self._keypoints(row) if skeleton is None else self._skeleton(skeleton)
            record = {
                "category_id": number,
                "track_id": number,
                **points,
                **self._target(row),
                **amodal,
            }
            if number in ids:
                visible.append((number, record))
            else:
                hidden.append(record)
        if ids & _OF_PERSON:
            person = {"category_id": PERSON_CATEGORY, "track_id": PERSON_CATEGORY}
            visible.append((PERSON_CATEGORY, {**person, **self._skeleton(frame.skeletons[0])}))
        for row in frame.objects:
            number = self._number(row["object"])
            if number in ids:
                visible.append((number, self._object(number, row)))
        image = image_id(self._sequence.name, frame.index, self._view)
        file.add_image(self._image(image, frame, hidden))
        if visible:
            masks = self._run_lengths(np.array([self._mask(seg, n) for n, _ in visible]))
            for (number, record), (runs, area, box) in zip(visible, masks, strict=True):
                file.add_annotation(
                    {
                        "id": image * INSTANCES + number,
                        "image_id": image,
                        "iscrowd": 0,
                        "bbox": box,
                        "area": area,
                        "segmentation": runs,
                        **record,
                    }
                )

    def _image(self, number: int, frame: FrameRows, hidden: list[dict[str, Any]]) -> dict[str, Any]:
        name = self._sequence.name
        return {
            "id": number,
            "license": LICENCE["id"],
            "file_name": f"{name}/{self._camera}/{picture_name(frame.index)}",
            "width": self._size.width_px,
            "height": self._size.height_px,
            "sequence": name,
            "frame_index": frame.index,
            "camera": self._camera,
            "pair_id": pair_id(name, frame.index),
            "timestamp_s": frame.stamp_s,
            "hidden_targets": hidden,
        }

    def _amodal_fields(self, index: int) -> list[dict[str, Any]]:
        """Amodal mask and box of each target, where the data set has them."""
        if not self._amodal:
            return [{} for _ in TARGETS]
        masks = self._run_lengths(self._sequence.amodal(self._view, index))
        return [
            {"amodal_segmentation": runs, "amodal_area": area, "amodal_bbox": box} if area else {}
            for runs, area, box in masks
        ]

    @staticmethod
    def _mask(seg: NDArray[np.uint8], number: int) -> NDArray[np.bool_]:
        """The mask (h, w) of a track: of the person, with head and hands."""
        if number == PERSON_CATEGORY:
            return np.asarray((seg > NOTHING) & (seg <= PERSON))
        return np.asarray(seg == number)

    def _keypoints(self, row: FrameRow) -> dict[str, Any]:
        camera = self._camera
        status, points = row[f"keypoint_status_{camera}"], row[f"keypoints_{camera}_px"]
        return _points(status, points, row["keypoints_m"])

    def _skeleton(self, row: FrameRow) -> dict[str, Any]:
        """Of a row of skeletons.parquet; COCO's points of the legs are not labelled."""
        camera = self._camera
        unlabelled = len(COCO_BODY) - len(BODY_POINTS) if row["skeleton"] == BODY_SKELETON else 0
        return _points(
            [*row[f"point_status_{camera}"], *(unlabelled * [NOT_LABELLED])],
            [*row[f"points_{camera}_px"], *(unlabelled * [None])],
            [*row["points_m"], *(unlabelled * [None])],
        )

    def _target(self, row: FrameRow) -> dict[str, Any]:
        camera = self._camera
        return {
            "visible_fraction": round(row[f"visible_fraction_{camera}"], _SHARE),
            "truncation": round(row[f"truncation_{camera}"], _SHARE),
            "occluded_by": {by["instance"]: by["pixels"] for by in row[f"occluded_by_{camera}"]},
            "position_m": _rounded([row[f"{axis}_m"] for axis in "xyz"], _M),
        }

    def _object(self, number: int, row: FrameRow) -> dict[str, Any]:
        name = row["object"]
        kind = self._kinds.get(name)
        if kind not in OBJECT_KINDS:
            raise FileError(
                self._sequence.folder / RIG, f"objects: {name!r} is of the unknown kind {kind!r}"
            )
        return {
            "category_id": FIRST_OBJECT_CATEGORY + OBJECT_KINDS.index(kind),
            "track_id": number,
            "name": name,
            "position_m": _rounded([row[f"{axis}_m"] for axis in "xyz"], _M),
        }

    def _number(self, name: str) -> int:
        number = self._ids.get(name)
        if number is None:
            raise FileError(self._sequence.folder / RIG, f"instances: has no object {name!r}")
        return number


def _points(
    status: list[int], pixels: list[Any], places_m: list[list[float] | None]
) -> dict[str, Any]:
    """COCO's fields of keypoints; those that no data set labels have no place."""
    flat: list[float] = []
    for state, point in zip(status, pixels, strict=True):
        known = state != NOT_LABELLED
        flat += [*(_rounded(point, _PX) if known else (0, 0)), state]
    return {
        "num_keypoints": sum(state != NOT_LABELLED for state in status),
        "keypoints": flat,
        "keypoints_3d_m": [None if p is None else _rounded(p, _M) for p in places_m],
    }


def _rounded(values: list[float], decimals: int) -> list[float]:
    return [round(value, decimals) for value in values]
