"""SHA256SUMS in the format of `sha256sum`: a line per file, sorted by path."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from pjpdaf.errors import FileError

_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def sha256_of(path: Path) -> str:
    """SHA-256 of a file, hexadecimal. Raises OSError."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def text_of(sums: Mapping[str, str]) -> str:
    """Text of a SHA256SUMS file from path -> SHA-256."""
    return "".join(f"{sums[path]}  {path}\n" for path in sorted(sums))


def read_sums(path: Path) -> dict[str, str]:
    """Read a SHA256SUMS file: path -> SHA-256.

    Raises FileError where it is missing or damaged, or names a file outside its folder.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as fault:
        raise FileError(path, f"cannot be read: {fault}") from fault
    sums = {}
    for number, line in enumerate(lines, 1):
        match = _LINE.fullmatch(line)
        parts = PurePosixPath(match[2]).parts if match else ()
        if not match or match[2].startswith("/") or ".." in parts:
            raise FileError(path, "is not a line of checksums inside this folder", number)
        sums[match[2]] = match[1]
    return sums


def files_below(folder: Path) -> list[Path]:
    """All files below a folder, hidden files too, sorted."""
    return sorted(path for path in folder.rglob("*") if path.is_file())
