"""All arrays of one frame of a sequence, as far as their files are there and whole."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pjpdaf.errors import BenchError
from sim.dataset.check.fault import Fault, fault_of
from sim.dataset.check.files import Tree
from sim.dataset.files.layout import picture_name
from sim.dataset.labels.records import Matches
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Eye:
    """One view. What was not asked for, is missing or damaged is None.

    picture, clean (h, w, 3) uint8; depth_m (h, w) float32, NaN for none; seg (h, w) uint8; amodal
    (h, w) uint8, a bit a target; rectified, matches: `Matches`; floats: of the NPZ file.
    """

    picture: NDArray[np.uint8] | None
    clean: NDArray[np.uint8] | None
    depth_m: NDArray[np.float32] | None
    seg: NDArray[np.uint8] | None
    amodal: NDArray[np.uint8] | None
    rectified: Matches | None
    matches: Matches | None
    floats: dict[str, NDArray[np.float32]] | None


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame of the sequence of this name."""

    name: str
    index: int
    eyes: tuple[Eye, Eye]

    def file(self, kind: str, view: int, suffix: str = ".png") -> str:
        """The file of a view, such as "seg" or "" for the picture itself."""
        folder = f"{kind}_{CAMERAS[view]}" if kind else CAMERAS[view]
        return f"{self.name}/{folder}/{picture_name(self.index, suffix)}"


def load(
    sequence: StoredSequence, tree: Tree, index: int, labels: Collection[str], faults: list[Fault]
) -> Frame:
    """Read a frame; faults of its files are added to the list, but for those of missing ones."""

    def read(read_it: Callable[[], T], label: str, *paths: str) -> T | None:
        if (label and label not in labels) or not tree.plain.issuperset(paths):
            return None
        try:
            return read_it()
        except BenchError as error:
            faults.append(fault_of(error, tree.root))
            return None

    def eye(v: int) -> Eye:
        camera = CAMERAS[v]

        def path(folder: str, suffix: str = ".png") -> str:
            return f"{sequence.name}/{folder}_{camera}/{picture_name(index, suffix)}"

        own = f"{sequence.name}/{camera}/{picture_name(index)}"
        bits = f"amodal_{camera}"
        return Eye(
            picture=read(lambda: sequence.picture(camera, index, np.uint8, 3), "", own),
            clean=read(lambda: sequence.clean(v, index), "clean", path("clean")),
            depth_m=read(lambda: sequence.depth_m(v, index), "depth", path("depth")),
            seg=read(lambda: sequence.seg(v, index), "seg", path("seg")),
            amodal=read(
                lambda: sequence.picture(bits, index, np.uint8, 1), "amodal", path("amodal")
            ),
            rectified=read(
                lambda: sequence.rectified(v, index),
                "disparity",
                path("disparity"),
                path("occlusion"),
            ),
            matches=read(
                lambda: sequence.matches(v, index), "correspondence", path("correspondence")
            ),
            floats=read(lambda: sequence.floats(v, index), "float", path("float", ".npz")),
        )

    return Frame(sequence.name, index, (eye(0), eye(1)))
