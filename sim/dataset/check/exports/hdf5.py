"""HDF5 files against the numbers and files of the sequences, where h5py is installed.

The library follows a file's own words to other files: only arrays that are in the file itself, of
the shape that the sequence gives, are read.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.errors import FileError
from sim.dataset.check.exports.numbers import SequenceNumbers
from sim.dataset.check.fault import MISSING, Fault
from sim.dataset.check.files import FileTree
from sim.dataset.files import encode
from sim.dataset.files.layout import LABELS, picture_name
from sim.scene.world import CAMERAS

FOLDER = "hdf5"
EVERY = 10  # frame of which pictures and labels are compared
_FOLDERS = [folder for label, own in LABELS.items() if label != "float" for folder in own]


def check_hdf5(tree: FileTree, numbers: SequenceNumbers) -> Iterator[Fault]:
    """Check the file of a sequence; nothing without h5py."""
    try:
        library: Any = importlib.import_module("h5py")
    except ImportError:
        return
    name = f"{FOLDER}/{numbers.name}.h5"
    if name not in tree.plain:
        yield Fault(name, MISSING)
        return
    try:
        with library.File(tree.root / name, "r") as file:
            yield from (Fault(name, text) for text in _faults(library, file, tree, numbers))
    # The library's faults of a damaged file are of all these kinds.
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as fault:
        yield Fault(name, f"is a damaged HDF5 file: {' '.join(str(fault).split())[:200]}")


def _faults(library: Any, file: Any, tree: FileTree, numbers: SequenceNumbers) -> Iterator[str]:
    for key, expected in _expected(numbers).items():
        array = _array(library, file, f"truth/{key}", expected.shape)
        if array is None:
            yield f"truth/{key} is not an array {expected.shape} in the file"
        elif not np.array_equal(array[...], expected, equal_nan=True):
            wrong = ~np.isclose(array[...], expected, rtol=0, atol=0, equal_nan=True)
            first = int(np.nonzero(wrong)[0][0])
            yield f"truth/{key} is not that of the tables, first in frame {first}"
    frames, (width, height) = len(numbers.arrived), numbers.size_px
    for group, folders in (("pictures", CAMERAS), ("labels", _FOLDERS)):
        for folder in folders:
            there = tree.names(f"{numbers.name}/{folder}")
            indices = [i for i in range(0, frames, EVERY) if picture_name(i) in there]
            if not indices:
                continue
            key = f"{group}/{folder}"
            one = (frames, height, width)
            stack = _array(library, file, key, one, (*one, 3))
            if stack is None or stack.chunks != (1, *stack.shape[1:]):
                yield f"{key} is not an array of {frames} pictures {width}x{height} in the file"
                continue
            for index in indices:
                path = tree.root / numbers.name / folder / picture_name(index)
                if not _same(stack[index], path):
                    yield f"{key} is not the picture of frame {index}"
                    break


def _expected(numbers: SequenceNumbers) -> dict[str, NDArray[Any]]:
    """The arrays of the tables' numbers."""
    arrays: dict[str, NDArray[Any]] = {
        "arrived": numbers.arrived.astype(np.uint8),
        "stamp_s": numbers.stamps_s,
        "positions_m": numbers.centres_m,
    }
    for view, camera in enumerate(CAMERAS):
        arrays |= {
            f"visible_{camera}_px": numbers.visible_px[view],
            f"visible_fractions_{camera}": numbers.fractions[view],
            f"boxes_{camera}_px": numbers.boxes_px[view],
            f"centroids_{camera}_px": numbers.centroids_px[view],
        }
        if numbers.object_ids:
            arrays[f"object_visible_{camera}_px"] = numbers.objects_px[view]
    return arrays


def _array(library: Any, file: Any, key: str, *shapes: tuple[int, ...]) -> Any | None:
    """The array of one of these shapes, None where there is none in the file itself."""
    place = file
    for word in key.split("/"):
        held = isinstance(place, library.Group) and word in place
        if not held or not isinstance(place.get(word, getlink=True), library.HardLink):
            return None
        place = place[word]
    if not isinstance(place, library.Dataset) or place.is_virtual or place.external:
        return None
    return place if place.shape in shapes and place.dtype.kind in "iuf" else None


def _same(stored: NDArray[Any], path: Path) -> bool:
    """Whether a picture is that of a PNG file; a damaged file has a fault of its own."""
    try:
        channels = 3 if stored.ndim == 3 else 1
        picture = encode.read_png(path, stored.dtype.type, channels)
    except FileError:
        return True
    return np.array_equal(stored, picture[..., ::-1] if channels == 3 else picture)
