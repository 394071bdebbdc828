"""All arrays of one frame of a sequence, as far as their files are there and whole."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Image
from sim.dataset.check.fault import FaultLog
from sim.dataset.check.files import FileTree
from sim.dataset.files.layout import picture_name
from sim.dataset.labels.records import Matches
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class ViewArrays:
    """Arrays of one view, None where a file is not wanted, missing or damaged.

    picture, clean (h, w, 3) uint8; depth_m (h, w) float32, NaN for nothing; seg (h, w) uint8;
    amodal (h, w) uint8, a bit per target; rectified, matches: `Matches`; classes (h, w) uint8;
    normals (h, w, 3) float32, NaN for nothing; forward, backward: flow; floats: of the NPZ file.
    """

    picture: Image | None
    clean: Image | None
    depth_m: NDArray[np.float32] | None
    seg: NDArray[np.uint8] | None
    amodal: NDArray[np.uint8] | None
    rectified: Matches | None
    matches: Matches | None
    classes: NDArray[np.uint8] | None
    normals: NDArray[np.float32] | None
    forward: Matches | None
    backward: Matches | None
    floats: dict[str, NDArray[np.float32]] | None


@dataclass(frozen=True, eq=False)
class FrameArrays:
    """Arrays of a frame. sequence: name of its folder; views: left, right."""

    sequence: str
    index: int
    views: tuple[ViewArrays, ViewArrays]

    def file(self, label: str, view: int, suffix: str = ".png") -> str:
        """Path of a view's file from the data set's folder; label: "seg", ...; "" the picture."""
        folder = f"{label}_{CAMERAS[view]}" if label else CAMERAS[view]
        return f"{self.sequence}/{folder}/{picture_name(self.index, suffix)}"


def present(array: T | None) -> T:
    """An array that must be there: a check runs only on frames with the arrays it compares."""
    assert array is not None
    return array


def read_arrays(
    sequence: StoredSequence, tree: FileTree, index: int, labels: Collection[str], log: FaultLog
) -> FrameArrays:
    """Read a frame; damaged files go to the log, missing files are left to `completeness`."""

    def read(label: str, folders: tuple[str, ...], reader: Callable[[], T]) -> T | None:
        suffix = ".npz" if label == "float" else ".png"
        name = picture_name(index, suffix)
        files = [f"{sequence.name}/{folder}/{name}" for folder in folders]
        if (label and label not in labels) or not tree.plain.issuperset(files):
            return None
        return log.read(reader)

    def read_view(v: int) -> ViewArrays:
        c = CAMERAS[v]
        amodal = f"amodal_{c}"
        pair = f"disparity_{c}", f"occlusion_{c}"
        return ViewArrays(
            picture=read("", (c,), lambda: sequence.picture(c, index, np.uint8, 3)),
            clean=read("clean", (f"clean_{c}",), lambda: sequence.clean(v, index)),
            depth_m=read("depth", (f"depth_{c}",), lambda: sequence.depth_m(v, index)),
            seg=read("seg", (f"seg_{c}",), lambda: sequence.seg(v, index)),
            amodal=read("amodal", (amodal,), lambda: sequence.picture(amodal, index, np.uint8, 1)),
            rectified=read("disparity", pair, lambda: sequence.rectified(v, index)),
            matches=read(
                "correspondence", (f"correspondence_{c}",), lambda: sequence.matches(v, index)
            ),
            classes=read("semantic", (f"semantic_{c}",), lambda: sequence.classes(v, index)),
            normals=read("normals", (f"normals_{c}",), lambda: sequence.normals(v, index)),
            forward=read("flow", (f"flow_forward_{c}",), lambda: sequence.flow(v, index)),
            backward=read(
                "flow", (f"flow_backward_{c}",), lambda: sequence.flow(v, index, "backward")
            ),
            floats=read("float", (f"float_{c}",), lambda: sequence.floats(v, index)),
        )

    return FrameArrays(sequence.name, index, (read_view(0), read_view(1)))
