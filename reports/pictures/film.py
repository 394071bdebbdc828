"""A film of overlay pictures: MP4 (H.264) with the extra `video`, else WebM (VP8)."""

from __future__ import annotations

import errno
import importlib
import os
import shutil
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pjpdaf.errors import InfrastructureError
from sim.files import write_fault

KEY_FRAME_S = 3.0  # a player can jump to every such moment


def film_suffix() -> str:
    """How the films of this installation end: .mp4 or .webm."""
    return ".webm" if _av() is None else ".mp4"


class FilmWriter:
    """Writes pictures (h, w, 3) uint8 BGR of one size, one at a time.

    `path` is known after the first picture. Raises InfrastructureError where no encoder opens or
    the disk is full, BenchError where the disk refuses otherwise; no part of a film is left then.
    """

    def __init__(self, folder: Path, stem: str, rate_hz: float) -> None:
        self.path: Path | None = None
        self._file = folder / f"{stem}{film_suffix()}"
        self._rate_hz = rate_hz
        self._writer: _Mp4 | _WebM | None = None

    def add(self, picture: np.ndarray) -> None:
        """The next picture."""
        height, width = picture.shape[:2]
        # Colour is stored at half resolution: both sides must be even.
        even = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        try:
            if self._writer is None:
                self._writer = _open(self._file, self._rate_hz, (even.shape[1], even.shape[0]))
                self.path = self._file
            self._writer.add(even)
        except OSError as error:
            self._give_up()
            raise write_fault(self._file, "the film", error) from error

    def close(self) -> None:
        """Finish the file; safe to call twice."""
        try:
            if self._writer is not None:
                self._writer.close()
                self._writer = None
        except OSError as error:
            self._give_up()
            raise write_fault(self._file, "the film", error) from error

    def _give_up(self) -> None:
        """No player opens a film without its end, and its room is needed."""
        writer, self._writer, self.path = self._writer, None, None
        if writer is not None:
            for step in (writer.drop, self._file.unlink):
                with suppress(OSError):
                    step()


def _av() -> Any:
    """PyAV where it is installed and has the encoder, else None."""
    try:
        av = importlib.import_module("av")
    except ImportError:
        return None
    return av if "libx264" in av.codecs_available else None


def _open(path: Path, rate_hz: float, size: tuple[int, int]) -> _Mp4 | _WebM:
    av = _av()
    return _WebM(path, rate_hz, size) if av is None else _Mp4(av, path, rate_hz, size)


class _Mp4:
    def __init__(self, av: Any, path: Path, rate_hz: float, size: tuple[int, int]) -> None:
        self._frame = av.VideoFrame.from_ndarray
        # The index goes to the front, so that a browser can start before it has all.
        self._file = av.open(str(path), "w", options={"movflags": "faststart"})
        rate = Fraction(rate_hz).limit_denominator(1001)
        gap = max(1, round(KEY_FRAME_S * rate_hz))
        options = {"crf": "26", "preset": "veryfast", "g": str(gap), "threads": "1"}
        self._stream = self._file.add_stream("libx264", rate=rate, options=options)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"  # the one that every player knows

    def add(self, picture: np.ndarray) -> None:
        self._file.mux(self._stream.encode(self._frame(picture, format="bgr24")))

    def close(self) -> None:
        self._file.mux(self._stream.encode(None))
        self._file.close()

    def drop(self) -> None:
        # One more packet after a failed one ends the process where the header was not written.
        self._file.close()


class _WebM:
    def __init__(self, path: Path, rate_hz: float, size: tuple[int, int]) -> None:
        self._folder = path.parent
        fourcc = cv2.VideoWriter.fourcc(*"VP80")
        self._file = cv2.VideoWriter(str(path), fourcc, rate_hz, size)
        if not self._file.isOpened():
            raise InfrastructureError(
                f"{path.name}: no encoder for films here; install the extra pjpdaf-bench[video]."
            )

    def add(self, picture: np.ndarray) -> None:
        # OpenCV goes on in silence on a full disk: ask beforehand.
        if shutil.disk_usage(self._folder).free < picture.nbytes:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._file.write(picture)

    def close(self) -> None:
        self._file.release()

    def drop(self) -> None:
        self.close()
