"""COCO's instances files, one a view: masks, boxes, keypoints, and more in fields of their own.

A picture that did not arrive has no entry. What no pixel shows has no annotation, for COCO's
readers take every annotation as something to be found; a hidden target is told of in its image's
field `hidden_targets` instead.
"""

from __future__ import annotations

import importlib
import json
import shutil
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.errors import BenchError, FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.folder import files_of, replaced_folder, sequences_of
from sim.dataset.files.layout import RIG, SCHEMA_VERSION, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, object_kinds, read_frame_rows
from sim.dataset.labels.records import HAND_POINTS, HEAD_POINTS, KEYPOINTS, NOT_LABELLED
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

FOLDER = "annotations"
# Their numbers are in files of others: a new kind comes at the end.
OBJECT_KINDS = (
    "can",
    "cup",
    "box",
    "ball",
    "book",
    "post",
    "rod",
    "block",
    "sheet",
    "phone",
    "arm",
    "balloon",
    "picture",
    "chair",
)
FIRST_OBJECT_CATEGORY = 10
# Ids are made of numbers that never change, so that a sequence has the same in every set of files:
# no sequence that is read is longer, and an instance's id is one byte. All stay below 2**53.
FRAMES, INSTANCES = 10_000_000, 256
LICENCE = {
    "id": 1,
    "name": "Creative Commons Attribution 4.0 International (CC BY 4.0)",
    "url": "https://creativecommons.org/licenses/by/4.0/",
}
_PX, _M, _SHARE = 3, 6, 6  # decimals: 0.001 px, 1 um; truth.parquet has all of them


def export(
    dataset: Dataset, into: Path, on_sequence: Callable[[str], None] = lambda name: None
) -> list[Path]:
    """Write `annotations/instances_left.json` and `instances_right.json`; see `registry.Export`.

    Needs the label `seg`; amodal masks are in it where the data set has the label `amodal`.
    """
    rle = _run_lengths()
    if "seg" not in dataset.labels:
        raise FileError(dataset.folder, "has no label seg, of which COCO's masks are made")
    folder = into / FOLDER
    with replaced_folder(folder, "COCO's files") as part, ExitStack() as stack:
        files = [stack.enter_context(_File(part / _name(camera), camera)) for camera in CAMERAS]
        for sequence in sequences_of(dataset):
            frames = read_frame_rows(sequence)
            for view, file in enumerate(files):
                _View(sequence, view, "amodal" in dataset.labels, rle).write(frames, file)
            on_sequence(sequence.name)
        for file in files:
            file.finish()
    return files_of(folder)


def pair_id(sequence: str, frame_index: int) -> int:
    """Of the two pictures of a frame; unique in a data set."""
    return int(sequence.rpartition("_")[2]) * FRAMES + frame_index + 1


def image_id(sequence: str, frame_index: int, view: int) -> int:
    """Of a picture; unique over both files."""
    return 2 * pair_id(sequence, frame_index) + view


def categories() -> list[dict[str, Any]]:
    """The same in every data set: targets with their keypoints, then kinds of objects."""
    found: list[dict[str, Any]] = []
    for t, target in enumerate(TARGETS):
        points, bones = (HAND_POINTS, _HAND_BONES) if t else (HEAD_POINTS, [[1, 2]])
        assert [name for owner, name in KEYPOINTS if owner == t] == list(points)
        found.append(
            {
                "id": 1 + t,
                "name": target,
                "supercategory": "person",
                "keypoints": list(points),
                "skeleton": bones,
            }
        )
    return found + [
        {"id": FIRST_OBJECT_CATEGORY + i, "name": kind, "supercategory": "object"}
        for i, kind in enumerate(OBJECT_KINDS)
    ]


# From the wrist to the palm and on to each tip; COCO counts keypoints from 1.
_HAND_BONES = [[1, 2], *([2, tip] for tip in range(3, len(HAND_POINTS) + 1))]


def _name(camera: str) -> str:
    return f"instances_{camera}.json"


class _RunLengths:
    """pycocotools' masks: (n, h, w) bool -> compressed, column-major runs, areas and boxes."""

    def __init__(self, library: Any) -> None:
        self._library = library

    def __call__(self, masks: NDArray[np.bool_]) -> list[tuple[dict[str, Any], int, list[int]]]:
        columns = np.ascontiguousarray(masks.transpose(0, 2, 1)).view(np.uint8)
        encoded = self._library.encode(columns.transpose(2, 1, 0))
        areas, boxes = self._library.area(encoded), self._library.toBbox(encoded)
        return [
            (
                {"size": list(map(int, one["size"])), "counts": one["counts"].decode("ascii")},
                int(area),
                [int(side) for side in box],
            )
            for one, area, box in zip(encoded, areas, boxes, strict=True)
        ]


def _run_lengths() -> _RunLengths:
    try:
        return _RunLengths(importlib.import_module("pycocotools.mask"))
    except ImportError as missing:
        raise BenchError(
            "COCO's masks need pycocotools, which is not installed: install pjpdaf-bench[dataset]."
        ) from missing


class _File:
    """One COCO file, written as it grows; the annotations wait beside it, not in memory."""

    def __init__(self, path: Path, camera: str) -> None:
        self._path, self._camera = path, camera
        self._first = {"images": True, "annotations": True}

    def __enter__(self) -> _File:
        self._images: IO[str] = self._path.open("w", encoding="ascii")
        self._annotations: IO[str] = tempfile.TemporaryFile(
            "w+", encoding="ascii", dir=self._path.parent
        )
        # No year and no date: the same data set gives the same bytes on any day.
        info = {
            "description": f"Stereo pictures of a seated person's head and hands, {self._camera} "
            "view, rendered with exact labels",
            "version": f"{SCHEMA_VERSION}",
            "contributor": "The pjpdaf-bench authors",
            "url": "",
        }
        head = {"info": info, "licenses": [LICENCE], "categories": categories()}
        self._images.write(_text(head)[:-1] + ',\n"images":[')
        return self

    def add_image(self, record: Mapping[str, Any]) -> None:
        """The next image."""
        self._add("images", self._images, record)

    def add_annotation(self, record: Mapping[str, Any]) -> None:
        """The next annotation."""
        self._add("annotations", self._annotations, record)

    def finish(self) -> None:
        """All is there: put both parts together."""
        self._images.write('\n],\n"annotations":[')
        self._annotations.seek(0)
        shutil.copyfileobj(self._annotations, self._images)
        self._images.write("\n]}\n")

    def _add(self, name: str, stream: IO[str], record: Mapping[str, Any]) -> None:
        stream.write(("\n" if self._first[name] else ",\n") + _text(record))
        self._first[name] = False

    def __exit__(self, *_: object) -> None:
        self._annotations.close()
        self._images.close()


class _View:
    """One view of a sequence."""

    def __init__(self, sequence: StoredSequence, view: int, amodal: bool, rle: _RunLengths) -> None:
        self._sequence, self._view, self._camera = sequence, view, CAMERAS[view]
        self._amodal, self._rle = amodal, rle
        self._size = sequence.rig.cameras[view]
        self._ids = {one.name: one.id for one in sequence.instances if one.kind == "object"}
        self._kinds = object_kinds(sequence)

    def write(self, frames: list[FrameRows], file: _File) -> None:
        """All that this view's pictures show."""
        for frame in frames:
            if frame.arrived[self._camera]:
                self._frame(file, frame)

    def _frame(self, file: _File, frame: FrameRows) -> None:
        seg = self._sequence.seg(self._view, frame.index)
        shown = set(np.flatnonzero(np.bincount(seg.ravel())).tolist())
        wanted: list[tuple[int, dict[str, Any]]] = []
        hidden = []
        for (number, row), whole in zip(
            enumerate(frame.targets, 1), self._whole(frame.index), strict=True
        ):
            record = {"category_id": number, "track_id": number, **self._target(row), **whole}
            if number in shown:
                wanted.append((number, record))
            else:
                hidden.append(record)
        for row in frame.objects:
            number = self._number(row["object"])
            if number in shown:
                wanted.append((number, self._object(number, row)))
        image = image_id(self._sequence.name, frame.index, self._view)
        file.add_image(self._image(image, frame, hidden))
        if wanted:
            masks = self._rle(
                seg[None] == np.array([n for n, _ in wanted], np.uint8)[:, None, None]
            )
            for (number, record), (runs, area, box) in zip(wanted, masks, strict=True):
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

    def _whole(self, index: int) -> list[dict[str, Any]]:
        """Of each target, its amodal mask and box, where the data set has them."""
        if not self._amodal:
            return [{} for _ in TARGETS]
        masks = self._rle(self._sequence.amodal(self._view, index))
        return [
            {"amodal_segmentation": runs, "amodal_area": area, "amodal_bbox": box} if area else {}
            for runs, area, box in masks
        ]

    def _target(self, row: FrameRow) -> dict[str, Any]:
        camera = self._camera
        status, points = row[f"keypoint_status_{camera}"], row[f"keypoints_{camera}_px"]
        flat: list[float] = []
        for said, point in zip(status, points, strict=True):
            known = said != NOT_LABELLED
            flat += [*(_rounded(point, _PX) if known else (0, 0)), said]
        return {
            "num_keypoints": sum(said != NOT_LABELLED for said in status),
            "keypoints": flat,
            "visible_fraction": round(row[f"visible_fraction_{camera}"], _SHARE),
            "truncation": round(row[f"truncation_{camera}"], _SHARE),
            "occluded_by": {one["instance"]: one["pixels"] for one in row[f"occluded_by_{camera}"]},
            "position_m": _rounded([row[f"{axis}_m"] for axis in "xyz"], _M),
            "keypoints_3d_m": [_rounded(point, _M) for point in row["keypoints_m"]],
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


def _rounded(values: list[float], decimals: int) -> list[float]:
    return [round(value, decimals) for value in values]


def _text(record: Mapping[str, Any]) -> str:
    return json.dumps(record, separators=(",", ":"), allow_nan=False)
