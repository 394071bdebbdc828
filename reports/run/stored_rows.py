"""The rows of an episode as bytes, and back: compressed JSON, then its pictures; no pickle."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import pyarrow as pa

from reports.run.rows import EpisodeRows
from reports.run.tables import tables_of
from reports.score.records import OverlayPicture, Still

_HEAD = struct.Struct("<4sQQ")  # magic, length of the JSON as it is stored, and unpacked
_MAGIC = b"rows"
MAX_JSON_BYTES = 1 << 28
_PICTURES = ("pictures", "film")
_PLAIN = tuple(field.name for field in fields(EpisodeRows) if field.name not in _PICTURES)
_ROWS = ("episodes", "events", "cameras")  # tuples of rows, lists in JSON


def rows_to_bytes(rows: EpisodeRows) -> bytes:
    """The rows as bytes; every number comes back as it was."""
    record: dict[str, Any] = {name: getattr(rows, name) for name in _PLAIN}
    record["pictures"] = [[p.frame, len(p.jpeg)] for p in rows.pictures]
    record["film"] = [[s.frame, len(s.webp)] for s in rows.film]
    text = json.dumps(record, separators=(",", ":"), default=_plain).encode()
    packed: bytes = pa.Codec("zstd", 3).compress(text, asbytes=True)
    blobs = [*(p.jpeg for p in rows.pictures), *(s.webp for s in rows.film)]
    return b"".join([_HEAD.pack(_MAGIC, len(packed), len(text)), packed, *blobs])


def rows_from_bytes(data: bytes) -> EpisodeRows:
    """Inverse of `rows_to_bytes`. Raises ValueError for anything else."""
    try:
        return _rows(data)
    except (KeyError, TypeError, AttributeError, OverflowError, RecursionError) as fault:
        raise ValueError(f"are no rows of an episode: {fault}") from fault
    except (OSError, struct.error, pa.ArrowException) as fault:
        raise ValueError(f"are damaged rows: {fault}") from fault


def _rows(data: bytes) -> EpisodeRows:
    magic, packed, size = _HEAD.unpack(data[: _HEAD.size])
    at = _HEAD.size + packed
    if magic != _MAGIC or size > MAX_JSON_BYTES or at > len(data):
        raise ValueError("are no rows of an episode")
    text = pa.Codec("zstd").decompress(data[_HEAD.size : at], size, asbytes=True)
    record = json.loads(text)
    plain = {name: record[name] for name in _PLAIN}
    plain |= {name: tuple(record[name]) for name in _ROWS}
    blobs = _blobs(data, at, [length for name in _PICTURES for _, length in record[name]])
    pictures = tuple(OverlayPicture(int(frame), next(blobs)) for frame, _ in record["pictures"])
    film = tuple(Still(int(frame), next(blobs)) for frame, _ in record["film"])
    rows = EpisodeRows(**plain, pictures=pictures, film=film)
    tables_of([rows])  # raises where a value is not of its column's type
    return rows


def _blobs(data: bytes, at: int, lengths: Iterable[int]) -> Any:
    blobs = []
    for length in lengths:
        if not isinstance(length, int) or not 0 <= length <= len(data) - at:
            raise ValueError("are cut short")
        blobs.append(data[at : at + length])
        at += length
    if at != len(data):
        raise ValueError("have bytes behind their end")
    return iter(blobs)


def _plain(value: object) -> object:
    """What JSON does not know: NumPy's numbers, and mappings that are no dictionaries."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"cannot store a {type(value).__name__}")
