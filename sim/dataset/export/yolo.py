"""YOLO's pose and segmentation as Ultralytics reads them: pictures, a text each, and data.yaml.

A line is a class and numbers as shares of width and height, from the corner of the picture: pixel
(0, 0), whose centre is our origin, is half a pixel from it. Pictures are hard links to the data
set's own where the disk has these, so that they take no room.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.targets import TARGETS
from sim.dataset.export.export import AddPart, Export, file_bytes, move_content
from sim.dataset.files.layout import picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, box_of, read_frame_rows
from sim.dataset.labels.records import HAND_JOINTS, HAND_SKELETONS
from sim.dataset.reader import Dataset
from sim.dataset.splits import splits_record
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import step

DIGITS = 6
# From a pixel's corner to that of a polygon in it: its centre, but for a hundredth, since some
# readers cut off the fraction of a pixel (Ultralytics), others round (supervision).
CENTRE_PX = 0.49
IMAGES, TEXTS = "images", "labels"  # folders, each with one of a split
Lines = Callable[[StoredSequence, FrameRows, int], list[str]]


def _write(lines: Lines, sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write the pictures of a sequence, and their texts. lines: of a picture's text."""
    for kind in (IMAGES, TEXTS):
        (part / kind).mkdir()
    for frame in read_frame_rows(sequence):
        for view, camera in enumerate(CAMERAS):
            if frame.arrived[camera]:
                name = f"{sequence.name}_{camera}_{picture_name(frame.index, '')}"
                picture = sequence.folder / camera / picture_name(frame.index)
                _link(picture, part / IMAGES / f"{name}.png")
                text = "".join(f"{line}\n" for line in lines(sequence, frame, view))
                (part / TEXTS / f"{name}.txt").write_text(text, "ascii")
        step()


@contextmanager
def _joining(
    names: Sequence[str], keypoints: str, dataset: Dataset, folder: Path
) -> Iterator[AddPart]:
    """Move each sequence's files to its split, and write data.yaml.

    names: of the classes; keypoints: what data.yaml says of them.
    """
    splits = splits_record(dataset.sequences)["splits"]
    split_of = {name: split for split, members in splits.items() for name in members}
    for split in splits:
        for kind in (IMAGES, TEXTS):
            (folder / kind / split).mkdir(parents=True)

    def add(sequence: StoredSequence, part: Path) -> None:
        for kind in (IMAGES, TEXTS):
            move_content(part / kind, folder / kind / split_of[sequence.name])

    yield add
    folders = "".join(f"{split}: {IMAGES}/{split}\n" for split in splits)
    classes = "".join(f"  {number}: {name}\n" for number, name in enumerate(names))
    (folder / "data.yaml").write_text(f"{folders}{keypoints}names:\n{classes}", "ascii")


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
            lines.append(_line(number, ((outline + CENTRE_PX) / size).ravel().tolist()))
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


pose = Export(
    "yolo-pose",
    "yolo-pose",
    "YOLO's files",
    partial(_write, _pose),
    partial(
        _joining,
        HAND_SKELETONS,
        f"kpt_shape: [{len(HAND_JOINTS)}, 3]\n"
        # A mirrored right hand is a left hand: train with fliplr 0.
        f"flip_idx: {list(range(len(HAND_JOINTS)))}\n",
    ),
)
segmentation = Export(
    "yolo-seg",
    "yolo-seg",
    "YOLO's files",
    partial(_write, _segmentation),
    partial(_joining, TARGETS, ""),
)
