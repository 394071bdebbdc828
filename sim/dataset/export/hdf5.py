"""HDF5: a file a sequence, with an array each of pictures, labels and truth; frames come first.

Pictures and labels are stored a frame a chunk, packed by HDF5's own deflate, which every reader
has. What a frame lacks (a lost picture, the flow of the last frame to a next) is zeros.
"""

from __future__ import annotations

import importlib
import io
import json
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.camera.normal_shader import STEPS, ZERO
from sim.dataset.export.export import Export
from sim.dataset.export.frame_columns import CAMERA_PARTS, sequence_values
from sim.dataset.export.hdf5_truth import truth_arrays
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import (
    DEPTH_UNIT_M,
    DISPARITY_SCALE,
    FLOW_SCALE,
    FLOW_ZERO,
    LABELS,
    frames_with,
)
from sim.dataset.frame_rows import FrameRows, read_frame_rows
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import step

SUFFIX = ".h5"
LEVEL = 1  # of deflate: higher ones take several times as long for a few per cent
_COLOURED = ("clean", "correspondence", "normals", "flow")  # labels of three channels
_WIDE = ("depth_", "disparity_", "correspondence_", "flow_")  # folders with 16 bits
# By the start of a folder's name: value = (number - zero) * scale, and its unit.
_SCALES = {
    "depth_": {"scale": DEPTH_UNIT_M, "zero": 0, "unit": "m"},
    "disparity_": {"scale": 1 / DISPARITY_SCALE, "zero": 0, "unit": "px"},
    "correspondence_": {"scale": 1 / FLOW_SCALE, "zero": FLOW_ZERO, "unit": "px"},
    "flow_": {"scale": 1 / FLOW_SCALE, "zero": FLOW_ZERO, "unit": "px"},
    "normals_": {"scale": 1 / STEPS, "zero": ZERO, "unit": ""},
}


def write_file(sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write the file of a sequence."""
    library: Any = importlib.import_module("h5py")
    frames = read_frame_rows(sequence)
    path = part / f"{sequence.name}{SUFFIX}"
    with _DiskFile(path, "w+b") as disk, library.File(disk, "w") as file:
        file.attrs.update({**sequence_values(sequence), "fps": sequence.fps})
        file["conventions"] = json.dumps(conventions())
        for kind, rig in (("cameras", sequence.rig), ("calibration", sequence.calibration)):
            for name, camera in zip(CAMERAS, rig.cameras, strict=True):
                for key in CAMERA_PARTS:
                    file[f"{kind}/{name}/{key}"] = getattr(camera, key)
        for name, values in truth_arrays(sequence, frames).items():
            file[f"truth/{name}"] = values
        for _ in _pictures_written(file, sequence, labels, frames):
            disk.check()
    disk.check()


class _DiskFile(io.FileIO):
    """A file that keeps the fault of its disk: HDF5's library would end the process at its end."""

    _fault: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all data, or nothing more after a fault."""
        rest = memoryview(data).cast("B")
        while rest and self._fault is None:
            try:
                rest = rest[super().write(rest) :]
            except OSError as fault:
                self._fault = fault
        return memoryview(data).nbytes

    def check(self) -> None:
        """Raise the fault of the disk, if there was one."""
        if self._fault is not None:
            raise self._fault


export = Export("hdf5", "hdf5", "the HDF5 files", write_file, library="h5py")


def _pictures_written(
    file: Any, sequence: StoredSequence, labels: Collection[str], frames: list[FrameRows]
) -> Iterator[None]:
    """Write pictures, labels and person-free pictures; yields after each frame."""
    count = len(frames)
    filmed = {camera: _Stack.of(file, sequence, "pictures", camera, 3, count) for camera in CAMERAS}
    labelled = [
        _Stack.of(file, sequence, "labels", folder, 3 if label in _COLOURED else 1, count)
        for label, folders in LABELS.items()
        if label in labels and label != "float"
        for folder in folders
    ]
    for frame in frames:
        for camera, stack in filmed.items():
            if frame.arrived[camera]:
                stack.copy(frame.index)
        for stack in labelled:
            if frame.index in frames_with(stack.folder, count):
                stack.copy(frame.index)
        if "float" in labels:
            for name, array in _floats(sequence, frame.index):
                if name not in file:
                    _create(file, name, (count, *array.shape), array.dtype)
                file[name][frame.index] = array
        step()
        yield
    for camera in CAMERAS:
        learnt = sequence.background_count
        stack = _Stack.of(file, sequence, "pictures", f"background_{camera}", 3, learnt)
        for index in range(learnt):
            stack.copy(index)


def _floats(sequence: StoredSequence, index: int) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """The arrays of the label `float` of a frame, and their names in the file."""
    for view, camera in enumerate(CAMERAS):
        for name, array in sequence.floats(view, index).items():
            yield f"labels/float_{camera}/{name}", array


@dataclass(frozen=True, eq=False)
class _Stack:
    """An array of the file that holds the pictures of a folder of the sequence."""

    sequence: StoredSequence
    folder: str
    channels: int
    array: Any

    @staticmethod
    def of(
        file: Any, sequence: StoredSequence, group: str, folder: str, channels: int, count: int
    ) -> _Stack:
        """A new array for `count` pictures, with what its numbers mean as attributes."""
        left = sequence.rig.left
        shape = (count, left.height_px, left.width_px, 3)[: 4 if channels == 3 else 3]
        dtype = np.uint16 if folder.startswith(_WIDE) else np.uint8
        array = _create(file, f"{group}/{folder}", shape, np.dtype(dtype))
        for start, scale in _SCALES.items():
            if folder.startswith(start):
                array.attrs.update(scale)
        return _Stack(sequence, folder, channels, array)

    def copy(self, index: int) -> None:
        """Copy a picture of the folder; three channels are in the order of its file: RGB."""
        picture = self.sequence.picture(self.folder, index, self.array.dtype.type, self.channels)
        self.array[index] = picture[..., ::-1] if self.channels == 3 else picture


def _create(file: Any, name: str, shape: tuple[int, ...], dtype: np.dtype[Any]) -> Any:
    """A new array, a chunk a picture."""
    return file.create_dataset(
        name,
        shape,
        dtype,
        chunks=(1, *shape[1:]),
        compression="gzip",
        compression_opts=LEVEL,
        shuffle=dtype.itemsize > 1,
    )
