"""A recorded sequence, read from a file: what a live simulation gives, without rendering.

All content is untrusted: nothing is executed or unpickled, and nothing is unpacked beyond the size
that it must have.
"""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import BinaryIO

import pyarrow as pa

from pjpdaf.camera import StereoRig
from pjpdaf.errors import FileError
from pjpdaf.frames import StereoFrame
from sim.camera.stereo_sensor import Light, background_frames, sense
from sim.recording.footer import Footer, read_footer
from sim.recording.lights import LightReader, Pictures, PicturesOnDemand
from sim.recording.truths import FRAME, FrameFacts, facts_from_bytes
from sim.truth import Truth

MAGIC = b"PJPREC1\n"
TAIL = struct.Struct("<QQ32s")  # start and length of the footer, SHA-256 of all before the digest
MAX_FOOTER_BYTES = 64 << 20


class Recording(AbstractContextManager["Recording"]):
    """A recorded sequence in an open file, which the context closes.

    All of the file is checked when it is opened. Raises FileError where it is damaged, OSError
    where it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = path.open("rb")
        try:
            self.footer = _checked_footer(self._file)
            self._facts = _facts(self._file, self.footer)
        except (ValueError, struct.error) as fault:
            self._file.close()
            raise FileError(path, f"is a damaged recording: {fault}") from fault
        except BaseException:
            self._file.close()
            raise

    @property
    def fps(self) -> float:
        """Frame rate [1/s]."""
        return self.footer.fps

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return len(self._facts)

    @property
    def redrawn(self) -> int:
        """Number of rejected draws of the seed (`sim.script.Performance`)."""
        return self.footer.redrawn

    @property
    def rig(self) -> StereoRig:
        """The cameras that filmed."""
        return self.footer.rig

    @property
    def calibration(self) -> StereoRig:
        """The calibration that a tracker is given."""
        return self.footer.calibration

    @property
    def renderer(self) -> str:
        """Description of the OpenGL renderer that drew it."""
        return self.footer.renderer

    def background(self) -> list[StereoFrame]:
        """The person-free frames, as `sim.sequence.Simulation.background` gives them."""
        footer, count = self.footer, self.footer.background_count
        if count == 0:
            return []
        light = self._read(self._lights(), 0)
        return background_frames(light, count, footer.fps, footer.sensor, footer.seed)

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """Yield all frames in order with their truth, as `sim.sequence.Simulation.frames` does."""
        lights = self._lights()
        for facts in self._facts:
            pictures = self._pictures(facts, lights)
            yield StereoFrame(facts.truth.index, facts.stamp_s, pictures), facts.truth

    def frames_on_demand(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """Yield all frames in order with their truth; pictures are read when one is looked at.

        That must happen before the recording is closed.
        """
        lights = self._lights()
        for facts in self._facts:
            pictures = PicturesOnDemand(partial(self._pictures, facts, lights))
            yield StereoFrame(facts.truth.index, facts.stamp_s, pictures), facts.truth

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _pictures(self, facts: FrameFacts, lights: LightReader) -> Pictures:
        index, footer = facts.truth.index, self.footer
        light = self._read(lights, index + (footer.background_count > 0))
        pictures = sense(light, footer.sensor, footer.seed, index, facts.truth.time_s)
        return tuple(p if came else None for p, came in zip(pictures, facts.arrived, strict=True))

    def _lights(self) -> LightReader:
        """A reader of the light of the background, if there is any, and of every frame."""
        camera, sizes = self.rig.left, self.footer.block_sizes[:-1]
        read_at = partial(_read_at, self._file)
        return LightReader(read_at, len(MAGIC), sizes, camera.height_px, camera.width_px)

    def _read(self, lights: LightReader, number: int) -> Light:
        try:
            return lights(number)
        except ValueError as fault:  # it was whole when it was opened
            raise FileError(self._path, f"was changed while it was read: {fault}") from fault


def _checked_footer(file: BinaryIO) -> Footer:
    """The footer of a file whose digest is right. Raises ValueError, struct.error."""
    size = os.fstat(file.fileno()).st_size
    if size < len(MAGIC) + TAIL.size or _read_at(file, 0, len(MAGIC)) != MAGIC:
        raise ValueError("it is none, or cut short")
    start, length, digest = TAIL.unpack(_read_at(file, size - TAIL.size, TAIL.size))
    if start + length != size - TAIL.size or length > MAX_FOOTER_BYTES:
        raise ValueError("its end is missing")
    if _digest(file, size - len(digest)) != digest:
        raise ValueError("its checksum is another")
    footer = read_footer(_read_at(file, start, length))
    if len(MAGIC) + sum(footer.block_sizes) != start:
        raise ValueError("its blocks are of other sizes")
    return footer


def _facts(file: BinaryIO, footer: Footer) -> tuple[FrameFacts, ...]:
    start = len(MAGIC) + sum(footer.block_sizes[:-1])
    packed = _read_at(file, start, footer.block_sizes[-1])
    size = FRAME.itemsize * len(footer.events)
    try:
        data = pa.Codec("zstd").decompress(packed, size, asbytes=True)
    except OSError as fault:  # of Arrow
        raise ValueError("its truth is not compressed") from fault
    return facts_from_bytes(data, footer.events)


def _read_at(file: BinaryIO, at: int, size: int) -> bytes:
    data = os.pread(file.fileno(), size, at)
    if len(data) != size:
        raise ValueError("it is cut short")
    return data


def _digest(file: BinaryIO, size: int) -> bytes:
    """SHA-256 of the first `size` bytes."""
    digest, at = hashlib.sha256(), 0
    while at < size:
        piece = _read_at(file, at, min(1 << 20, size - at))
        digest.update(piece)
        at += len(piece)
    return digest.digest()
