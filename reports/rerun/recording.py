"""A recording for the Rerun viewer: its file, its entities, and its cameras.

Written in memory first: Rerun's own files tell of a full disk only as a RuntimeError.
"""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.camera import Camera
from pjpdaf.errors import BenchError, InfrastructureError
from sim.files import disk_faults, written_whole_file

SUFFIX = ".rrd"
APPLICATION = "pjpdaf-bench"
QUALITY = 60  # of the pictures as JPEG: the viewer reads no WebP
# Rerun counts pixels from the corner of the top-left pixel, we from its centre.
CORNER_PX = 0.5
# As the report page's dark side (page.css): distinct for the colour-blind, too.
TARGET_RGB = ((255, 143, 94), (63, 214, 160), (116, 189, 255))


@dataclass(frozen=True, eq=False)
class Entities:
    """The entities below a root path of a recording. rr: the package `rerun`."""

    rr: Any
    stream: Any
    root: tuple[str, ...]

    def path(self, *parts: str) -> str:
        """Entity path below the root."""
        return str(self.rr.new_entity_path([*self.root, *parts]))

    def log(self, parts: tuple[str, ...], *components: Any) -> None:
        """Log components at the times that were set last."""
        self.stream.log(self.path(*parts), *components)

    def log_static(self, parts: tuple[str, ...], *components: Any) -> None:
        """Log components that hold at all times."""
        self.stream.log(self.path(*parts), *components, static=True)

    def log_camera(self, view: str, camera: Camera, *components: Any) -> None:
        """Log a camera as cameras/VIEW: pose, pinhole, and further components."""
        K = np.array(camera.K)
        K[:2, 2] += CORNER_PX
        self.log_static(
            ("cameras", view),
            self.rr.Transform3D(translation=camera.centre_w, mat3x3=camera.R_cw.T),
            self.rr.Pinhole(
                image_from_camera=K,
                resolution=[camera.width_px, camera.height_px],
                camera_xyz=self.rr.ViewCoordinates.RDF,
                image_plane_distance=0.3,
            ),
            *components,
        )


def check_suffix(file: Path) -> None:
    """Raise BenchError unless the file's name ends as a recording's."""
    if file.suffix.lower() != SUFFIX:
        raise BenchError(f"{file}: must end in {SUFFIX}.")


def write_recording(
    file: Path, name: str, identity: str, log_all: Callable[[Any, Any, Any], Any]
) -> Path:
    """Write one new `file` (.rrd) and return it.

    identity: recordings of the same are merged by the viewer. log_all(rr, blueprint, stream) logs
    everything into the stream and returns the blueprint of the views.

    Raises BenchError where the file exists or ends otherwise; InfrastructureError where Rerun is
    not installed or switched off, or the disk is full.
    """
    check_suffix(file)
    try:
        rr = importlib.import_module("rerun")
    except ImportError:
        raise InfrastructureError(
            f"{file}: recordings need the extra: pip install 'pjpdaf-bench[viz]'."
        ) from None
    with written_whole_file(file, "the recording") as part, _strict(rr):
        # A stream's own properties are the wall-clock time and the program's name.
        stream = rr.RecordingStream(APPLICATION, recording_id=identity, send_properties=False)
        if hasattr(stream, "set_log_time_enabled"):  # of newer versions; wall clock is no result
            stream.set_log_time_enabled(False)
        if not rr.is_enabled(stream):
            raise InfrastructureError("Rerun is switched off by the variable RERUN: unset it.")
        buffer = stream.binary_stream()
        stream.send_recording_name(name)
        stream.send_blueprint(log_all(rr, importlib.import_module("rerun.blueprint"), stream))
        content = buffer.read()  # once: a second part would follow the file's end mark
        stream.disconnect()
        with disk_faults(file, "the recording"):
            part.write_bytes(content)
    return file


def identity_of(value: Any) -> str:
    """An id of 32 hexadecimal digits, equal for equal plain values."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:32]


@contextmanager
def _strict(rr: Any) -> Iterator[None]:
    """Raise faults of logged data, of which Rerun otherwise warns and leaves the data out."""
    before = rr.strict_mode()
    rr.set_strict_mode(True)
    try:
        yield
    finally:
        rr.set_strict_mode(before)
