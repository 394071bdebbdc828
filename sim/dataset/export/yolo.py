"""YOLO's pose and segmentation as Ultralytics reads them: pictures, a text each, and data.yaml.

A line is a class and numbers as shares of width and height, from the corner of the picture: pixel
(0, 0), whose centre is our origin, is half a pixel from it. Pictures are hard links to the data
set's own where the disk has these, so that they take no room.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.dataset.export.export import AddSequence, Export, file_bytes
from sim.dataset.files.layout import picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, box_of, read_frame_rows
from sim.dataset.labels.records import HAND_JOINTS, HAND_SKELETONS
from sim.dataset.reader import Dataset
from sim.dataset.splits import splits_record
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import step

DIGITS = 6
Lines = Callable[[StoredSequence, FrameRows, int], list[str]]


def _exporter(
    folder: str, names: Sequence[str], lines: Lines, *, keypoints: str = "", needs_seg: bool = False
) -> Export:
    """The export of one task. names: of the classes; lines: of a picture's text.

    keypoints: what data.yaml says of them.
    """

    @contextmanager
    def write(dataset: Dataset, into: Path) -> Iterator[AddSequence]:
        if needs_seg and "seg" not in dataset.labels:
            raise FileError(dataset.folder, "has no label seg, of which the polygons are made")
        splits = splits_record(dataset.sequences)["splits"]
        split_of = {name: split for split, names in splits.items() for name in names}
        for split in splits:
            for kind in ("images", "labels"):
                (into / kind / split).mkdir(parents=True)

        def add(sequence: StoredSequence) -> None:
            for frame in read_frame_rows(sequence):
                for view, camera in enumerate(CAMERAS):
                    if frame.arrived[camera]:
                        split = split_of[sequence.name]
                        name = f"{sequence.name}_{camera}_{picture_name(frame.index, '')}"
                        picture = sequence.folder / camera / picture_name(frame.index)
                        _link(picture, into / "images" / split / f"{name}.png")
                        text = "".join(f"{line}\n" for line in lines(sequence, frame, view))
                        (into / "labels" / split / f"{name}.txt").write_text(text, "ascii")
                step()

        yield add
        folders = "".join(f"{split}: images/{split}\n" for split in splits)
        classes = "".join(f"  {number}: {name}\n" for number, name in enumerate(names))
        (into / "data.yaml").write_text(f"{folders}{keypoints}names:\n{classes}", "ascii")

    return Export(folder, "YOLO's files", write)


def _pose(sequence: StoredSequence, frame: FrameRows, view: int) -> list[str]:
    """Both hands that the picture shows: box, then x, y, v of the 21 joints."""
    camera, size = CAMERAS[view], sequence.rig.cameras[view]
    shares = 1 / np.array([size.width_px, size.height_px])
    lines = []
    for number, (target, skeleton) in enumerate(
        zip(frame.targets[1:], frame.skeletons[1:], strict=True)
    ):
        box = box_of(target, camera)
        if box is not None:
            x, y, width, height = box
            middle = np.array([x + width / 2, y + height / 2, width, height]) * np.tile(shares, 2)
            lines.append(_line(number, [*middle, *_joints(skeleton, camera, shares)]))
    return lines


def _joints(skeleton: FrameRow, camera: str, shares: NDArray[np.float64]) -> list[float]:
    numbers: list[float] = []
    pixels, status = skeleton[f"points_{camera}_px"], skeleton[f"point_status_{camera}"]
    for point, state in zip(pixels, status, strict=True):
        known = (np.array(point) + 0.5) * shares if state else np.zeros(2)
        numbers += [*known.tolist(), float(state)]
    return numbers


def _segmentation(sequence: StoredSequence, frame: FrameRows, view: int) -> list[str]:
    """A polygon a target that the picture shows, through the centres of its outermost pixels."""
    seg = sequence.seg(view, frame.index)
    size = np.array(seg.shape[::-1])
    lines = []
    for number in range(len(TARGETS)):
        outline = polygon(seg == 1 + number)
        if len(outline) >= 3:
            lines.append(_line(number, ((outline + 0.5) / size).ravel().tolist()))
    return lines


def polygon(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """One polygon (n, 2) of a mask's pixels, as x, y; filled by even and odd, it is the mask.

    Parts and holes are joined by lines that are walked there and back.
    """
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    rings = [np.asarray(contour[:, 0], np.int64) for contour in found]
    if not rings:
        return np.zeros((0, 2), np.int64)
    whole = [np.concatenate([ring, ring[:1]]) for ring in rings]
    home = [ring[:1] for ring in rings[-2::-1]]
    return np.concatenate([*whole, *home])


def _line(number: int, values: list[float]) -> str:
    return " ".join([str(number), *(f"{round(value, DIGITS):g}" for value in values)])


def _link(source: Path, target: Path) -> None:
    """Hard link a picture, or copy it. Raises FileError where it is none, or a link."""
    file_bytes(source)
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)


pose = _exporter(
    "yolo-pose",
    HAND_SKELETONS,
    _pose,
    keypoints=f"kpt_shape: [{len(HAND_JOINTS)}, 3]\n"
    # A mirrored right hand is a left hand: train with fliplr 0.
    f"flip_idx: {list(range(len(HAND_JOINTS)))}\n",
)
segmentation = _exporter("yolo-seg", TARGETS, _segmentation, needs_seg=True)
