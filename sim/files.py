"""Files that appear whole or not at all, and the messages for a disk that refuses to write."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from pjpdaf.errors import BenchError, InfrastructureError, closest

FULL = (errno.ENOSPC, errno.EDQUOT)
_REMEDIES = {
    errno.ENOSPC: " Free some space there, or write to another disk.",
    errno.EDQUOT: " Remove files of yours there, or write to another disk.",
    errno.EACCES: " Choose a folder that you may write to.",
    errno.EPERM: " Choose a folder that you may write to.",
    errno.EROFS: " Choose a folder that you may write to.",
    errno.ENOENT: " Make its folder first.",
    errno.ENOTDIR: " A part of the path is a file: choose another.",
    errno.EISDIR: " It is a folder: add a file name.",
    errno.ENAMETOOLONG: " Choose a shorter name.",
}


def write_fault(path: Path, content: str, error: OSError) -> BenchError:
    """The fault, in one line, of a disk that refused to write `content` to `path`.

    InfrastructureError (exit code 5) where the disk or the user's share of it is full, else
    BenchError (exit code 2).
    """
    # Of libraries (Arrow, FFmpeg) only the number is in one form.
    number = error.errno
    reason = os.strerror(number) if number else " ".join(str(error).split()).rstrip(".")
    remedy = _REMEDIES.get(number or 0, "")
    kind = InfrastructureError if number in FULL else BenchError
    return kind(f"{_final_path(path)}: cannot write {content}: {reason}.{remedy}")


@contextmanager
def disk_faults(path: Path, content: str) -> Iterator[None]:
    """Turn any OSError inside into the fault of `write_fault`."""
    try:
        yield
    except OSError as error:
        raise write_fault(path, content, error) from error


@contextmanager
def written_whole_file(path: Path, content: str, *, replace: bool = False) -> Iterator[Path]:
    """A path to write to, in a temporary folder; at the end of the block it becomes `path`.

    An exception inside removes it. Raises BenchError where `path` is a folder, exists (unless
    `replace`), or cannot be written.
    """
    path = path.absolute()
    with disk_faults(path, content):
        if path.is_dir():
            raise BenchError(f"{path}: is a folder; add a file name.")
        if path.exists() and not replace:
            raise BenchError(f"{path}: exists; give another name, or remove it first.")
        part = part_folder(path)
    try:
        yield part / path.name
        with disk_faults(path, content):
            (part / path.name).replace(path)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def near_paths(path: Path) -> str:
    """Return "; did you mean X?" for what lies beside a missing file or folder and is most like it.

    Only of the same ending; "" where there is none.
    """
    try:
        beside = [one.name for one in path.absolute().parent.iterdir() if one.exists()]
    except OSError:
        return ""
    near = closest(path.name, [name for name in beside if Path(name).suffix == path.suffix])
    names = " or ".join(str(path.parent / name) for name in near)
    return f"; did you mean {names}?" if near else ""


def part_folder(path: Path) -> Path:
    """Make a hidden folder beside `path`, on the same disk, to write into. Raises OSError."""
    return Path(tempfile.mkdtemp(prefix=f".{path.name}.part-", dir=path.parent))


def files_digest(root: Path, paths: Iterable[Path]) -> str:
    """SHA-256 of the contents of files and of their names from `root`, in any order of `paths`."""
    digest = hashlib.sha256()
    for name, path in sorted((path.relative_to(root).as_posix(), path) for path in paths):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{content}  {name}\n".encode())
    return digest.hexdigest()


def _final_path(path: Path) -> Path:
    """The final path of a file in a part folder: messages do not name part folders."""
    return Path(re.sub(r"/\.([^/]+)\.part-\w+(?:/\1(?=/|$))?", r"/\1", str(path)))
