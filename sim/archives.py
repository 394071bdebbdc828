"""ZIP archives of unknown origin: bounded before anything of them is unpacked."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

MAX_DIRECTORY_BYTES = 8 << 20  # of the list of entries: some 100 000
_END, _END_BYTES, _COMMENT_BYTES = b"PK\x05\x06", 22, 1 << 16


def bounded_archive(path: Path, most_bytes: int) -> zipfile.ZipFile:
    """Open an archive whose entries have at most `most_bytes` together, unpacked.

    Reading an entry never gives more than the size that the archive states. Raises OSError,
    zipfile.BadZipFile, also for an archive that is larger.
    """
    if _directory_bytes(path) > MAX_DIRECTORY_BYTES:
        raise zipfile.BadZipFile("has too many entries")
    archive = zipfile.ZipFile(path)
    if sum(entry.file_size for entry in archive.infolist()) > most_bytes:
        archive.close()
        raise zipfile.BadZipFile(f"is larger than {most_bytes >> 20} MiB unpacked")
    return archive


def _directory_bytes(path: Path) -> int:
    """Size of the list of entries, which `zipfile` reads whole, from the record at the end."""
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - _END_BYTES - _COMMENT_BYTES))
        tail = file.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) - at < _END_BYTES:
        raise zipfile.BadZipFile("File is not a zip file")
    # 0xffffffff in an archive of more than 4 GiB, which is refused with the others.
    directory_bytes: int = struct.unpack_from("<L", tail, at + 12)[0]
    return directory_bytes
