"""OpenCV's FileStorage (YAML or XML) from unknown hands, read number by number.

`FileNode.mat()` trusts the file: a matrix without `cols`, or with fewer numbers in `data` than rows
x cols, is written past its end. Nothing here calls it.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import FileError

MAX_BYTES = 4 << 20
MAX_NUMBERS = 1000  # of a matrix; those of a calibration have up to 16
# OpenCV's parser calls itself for each part inside another, and ends the process at some 50 000.
MAX_NESTING = 5000
_NESTING = re.compile(r"[\[{<:]|-\s")
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_MATLAB = (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file", b"\x89HDF\r\n\x1a\n")


class OpenCvFile:
    """A file of OpenCV's FileStorage, or any YAML that its parser reads. Close it after use.

    A key is a path of names, such as ("cam0", "intrinsics"). Each fault is a FileError.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        text = _read_text(path)
        if not text.lstrip().startswith(("%YAML", "<?xml", "{")):
            # What OpenCV's parser needs and other programs do not write: a head, and lists further
            # in than their names.
            text = "%YAML:1.0\n---\n" + re.sub(r"^( *- )", r"  \1", text, flags=re.MULTILINE)
        level = cv2.utils.logging.getLogLevel()
        cv2.utils.logging.setLogLevel(0)  # OpenCV prints its own account of the faults raised here
        try:
            flags = cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY
            self._storage = cv2.FileStorage(text, flags)
            self.keys = tuple(self._storage.root().keys()) if self._storage.isOpened() else ()
        except (cv2.error, SystemError, UnicodeDecodeError):
            self.keys = ()
        finally:
            cv2.utils.logging.setLogLevel(level)
        if not self.keys:
            raise FileError(
                path, "not a calibration file (OpenCV's YAML or XML, ROS camera_info, Kalibr)"
            )

    def close(self) -> None:
        """Release the parsed file."""
        self._storage.release()

    def has(self, *key: str) -> bool:
        """Whether the file has a key."""
        node = self._node(key)
        return node is not None and not (node.isNone() or node.empty())

    def first(self, *names: str) -> str | None:
        """The first of these top-level keys that the file has."""
        return next((name for name in names if name in self.keys), None)

    def matrix(self, *key: str) -> Floats:
        """Return the matrix of a key (OpenCV's, or ROS's rows, cols, data), of finite numbers."""
        node = self._needed(key)
        name = ".".join(key)
        if not node.isMap():
            raise FileError(self.path, f"{name} is not a matrix (!!opencv-matrix)")
        rows, columns = self._shape(node, name)
        kind = node.getNode("dt")
        if not kind.isNone() and not (kind.isString() and kind.string() in ("d", "f", "i")):
            raise FileError(self.path, f"{name} is not a matrix of numbers (dt must be d)")
        if rows * columns > MAX_NUMBERS:
            raise FileError(self.path, f"{name} is {rows}x{columns}: too large for a calibration")
        values = self._sequence(node.getNode("data"), name)
        if len(values) != rows * columns:
            raise FileError(
                self.path,
                f"{name} is {rows}x{columns} but its data have {len(values)} numbers",
            )
        return values.reshape(rows, columns)

    def numbers(self, *key: str) -> Floats:
        """Return a plain list of finite numbers (n,)."""
        return self._sequence(self._needed(key), ".".join(key))

    def table(self, *key: str) -> Floats:
        """Return a list of equally long lists of finite numbers (n, m)."""
        node, name = self._needed(key), ".".join(key)
        if not node.isSeq() or node.size() > MAX_NUMBERS:
            raise FileError(self.path, f"{name} must be a list of rows")
        rows = [self._sequence(node.at(i), name) for i in range(node.size())]
        if len({len(row) for row in rows}) != 1:
            raise FileError(self.path, f"{name} must have rows of one length")
        return np.array(rows)

    def number(self, *key: str) -> float:
        """Return a number."""
        node = self._needed(key)
        if not (node.isInt() or node.isReal()):
            raise FileError(self.path, f"{'.'.join(key)} is not a number")
        return float(node.real())

    def text(self, *key: str) -> str:
        """Return a text; "" where the file has none."""
        node = self._node(key)
        return str(node.string()) if node is not None and node.isString() else ""

    def _node(self, key: Sequence[str]) -> Any | None:
        node = self._storage.root()
        for name in key:
            if not node.isMap() or name not in node.keys():  # noqa: SIM118 - not a mapping
                return None
            node = node.getNode(name)
        return node

    def _needed(self, key: Sequence[str]) -> Any:
        node = self._node(key)
        if node is None:
            listed = ", ".join(sorted(name[:40] for name in self.keys)[:20])
            raise FileError(self.path, f"key {'.'.join(key)} is missing. It has {listed}")
        return node

    def _shape(self, node: Any, name: str) -> tuple[int, int]:
        sizes = node.getNode("sizes")  # of !!opencv-nd-matrix
        if not sizes.isNone():
            shape = [int(n) for n in self._sequence(sizes, f"{name}.sizes")] + [1]
        else:
            parts = [node.getNode(part) for part in ("rows", "cols")]
            if not all(part.isInt() for part in parts):
                raise FileError(self.path, f"{name} is not a matrix: it has no rows and cols")
            shape = [int(part.real()) for part in parts]
        if not all(0 < n <= MAX_NUMBERS for n in shape) or int(np.prod(shape[2:])) != 1:
            raise FileError(self.path, f"{name} has no size of a matrix")
        return shape[0], shape[1]

    def _sequence(self, node: Any, name: str) -> Floats:
        size = node.size() if node.isSeq() else -1
        if not 0 <= size <= MAX_NUMBERS:
            raise FileError(self.path, f"{name} must be a list of up to {MAX_NUMBERS} numbers")
        items = [node.at(i) for i in range(size)]
        if not all(item.isInt() or item.isReal() for item in items):
            raise FileError(self.path, f"{name} has values that are no numbers")
        values = np.array([item.real() for item in items], dtype=np.float64)
        if not np.isfinite(values).all():
            raise FileError(self.path, f"{name} has values that are not finite numbers")
        return values


def _read_text(path: Path) -> str:
    """The text of the file, without a byte-order mark (Windows editors write one)."""
    if not path.is_file():
        raise FileError(path, "no such calibration file")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FileError(path, f"is larger than {MAX_BYTES >> 20} MiB: not a calibration")
        content = path.read_bytes()
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror or fault}") from fault
    if content.startswith(_MATLAB):
        raise FileError(
            path,
            "is a MATLAB file; in MATLAB: [K1, D1, K2, D2, R, T] = stereoParametersToOpenCV("
            "stereoParams), and write these as an OpenCV YAML (docs/real_footage.md)",
        )
    mark, encoding = next((m for m in _MARKS if content.startswith(m[0])), (b"", "utf-8"))
    try:
        text = content[len(mark) :].decode(encoding)
    except UnicodeDecodeError:
        raise FileError(path, "not a calibration file: it is not text") from None
    if "\0" in text:
        raise FileError(path, "not a calibration file: it is not text")
    if len(_NESTING.findall(text)) > MAX_NESTING:
        raise FileError(path, "not a calibration file: it has too many parts")
    return text
