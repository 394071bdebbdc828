"""A COCO file, put together from the records of sequences, and its run-length masks."""

from __future__ import annotations

import importlib
import json
import shutil
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

KINDS = IMAGES, ANNOTATIONS = "images", "annotations"
SEPARATOR = ",\n"  # between records


class RunLengths:
    """pycocotools' masks."""

    def __init__(self) -> None:
        self._library: Any = importlib.import_module("pycocotools.mask")

    def __call__(self, masks: NDArray[np.bool_]) -> list[tuple[dict[str, Any], int, list[int]]]:
        """Compressed column-major runs, area and box of each of n masks (n, h, w)."""
        columns = np.ascontiguousarray(masks.transpose(0, 2, 1)).view(np.uint8)
        encoded = self._library.encode(columns.transpose(2, 1, 0))
        areas, boxes = self._library.area(encoded), self._library.toBbox(encoded)
        return [
            (
                {"size": list(map(int, runs["size"])), "counts": runs["counts"].decode("ascii")},
                int(area),
                [int(side) for side in box],
            )
            for runs, area, box in zip(encoded, areas, boxes, strict=True)
        ]


class CocoRecords:
    """Writes the records of a sequence's view into two files of a folder; `stack` closes them."""

    def __init__(self, folder: Path, camera: str, stack: ExitStack) -> None:
        self._files = {
            kind: stack.enter_context(_records(folder, kind, camera).open("w", encoding="ascii"))
            for kind in KINDS
        }
        self._separators = dict.fromkeys(KINDS, "")

    def add_image(self, record: Mapping[str, Any]) -> None:
        """Add an image."""
        self._add(IMAGES, record)

    def add_annotation(self, record: Mapping[str, Any]) -> None:
        """Add an annotation."""
        self._add(ANNOTATIONS, record)

    def _add(self, kind: str, record: Mapping[str, Any]) -> None:
        self._files[kind].write(self._separators[kind] + _text(record))
        self._separators[kind] = SEPARATOR


class CocoFile:
    """Writes a file of images and annotations; the annotations wait in a file beside it.

    head: the other fields of the file. Call `finish` after the last records; `stack` closes it.
    """

    def __init__(self, path: Path, head: Mapping[str, Any], stack: ExitStack) -> None:
        self._images: IO[str] = stack.enter_context(path.open("w", encoding="ascii"))
        waiting = tempfile.TemporaryFile("w+", encoding="ascii", dir=path.parent)  # noqa: SIM115
        self._annotations: IO[str] = stack.enter_context(waiting)
        self._separators = dict.fromkeys(KINDS, "\n")
        self._images.write(_text(head)[:-1] + ',\n"images":[')

    def add(self, folder: Path, camera: str) -> None:
        """Append the records of a view in the folder of a `CocoRecords`."""
        for kind, stream in zip(KINDS, (self._images, self._annotations), strict=True):
            path = _records(folder, kind, camera)
            if path.stat().st_size:
                stream.write(self._separators[kind])
                self._separators[kind] = SEPARATOR
                with path.open(encoding="ascii") as records:
                    shutil.copyfileobj(records, stream)

    def finish(self) -> None:
        """Append the annotations to the images."""
        self._images.write('\n],\n"annotations":[')
        self._annotations.seek(0)
        shutil.copyfileobj(self._annotations, self._images)
        self._images.write("\n]}\n")


def _records(folder: Path, kind: str, camera: str) -> Path:
    return folder / f"{kind}_{camera}.txt"


def _text(record: Mapping[str, Any]) -> str:
    return json.dumps(record, separators=(",", ":"), allow_nan=False)
