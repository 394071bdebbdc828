"""Arrays by name in one file, with the plain values that decided them, and a checksum of all.

The content is untrusted: nothing is executed or unpickled, and nothing is unpacked beyond the size
that it says it has, `MAX_BYTES` at most.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

MAGIC = b"PJPARR1\n"
HEAD = struct.Struct("<Q")  # bytes of the JSON that follows
DIGEST_BYTES = 32
LEVEL = 3  # of zstd
MAX_BYTES = 1 << 29
TYPES = ("|u1", "<i4", "<f8")

Arrays = Mapping[str, NDArray[Any]]


def arrays_to_bytes(record: Mapping[str, object], arrays: Arrays) -> bytes:
    """A file's content. Raises ValueError for arrays of other types, or of too many bytes."""
    heads, parts = [], []
    for name, array in arrays.items():
        if array.dtype.str not in TYPES:
            raise ValueError(f"{name}: is of type {array.dtype}")
        heads.append([name, array.dtype.str, list(array.shape)])
        # Bytes of the same rank side by side: exponents are alike, last bits are not.
        parts.append(np.ascontiguousarray(array).view(np.uint8).reshape(-1, array.itemsize).T)
    data = b"".join(part.tobytes() for part in parts)
    if len(data) > MAX_BYTES:
        raise ValueError(f"more than {MAX_BYTES} bytes")
    packed = pa.Codec("zstd", LEVEL).compress(data, asbytes=True)
    head = json.dumps({"key": dict(record), "arrays": heads}, sort_keys=True).encode()
    content: bytes = MAGIC + HEAD.pack(len(head)) + head + packed
    return content + hashlib.sha256(content).digest()


def arrays_from_bytes(content: bytes) -> tuple[Mapping[str, Any], dict[str, NDArray[Any]]]:
    """The inverse of `arrays_to_bytes`. Raises ValueError for anything else."""
    start = len(MAGIC) + HEAD.size
    if len(content) < start + DIGEST_BYTES or not content.startswith(MAGIC):
        raise ValueError("is none, or cut short")
    if hashlib.sha256(content[:-DIGEST_BYTES]).digest() != content[-DIGEST_BYTES:]:
        raise ValueError("its checksum is another")
    (length,) = HEAD.unpack(content[len(MAGIC) : start])
    try:
        head = json.loads(content[start : start + length])
        record, heads = dict(head["key"]), [_head(*one) for one in head["arrays"]]
        sizes = [math.prod(shape) * np.dtype(kind).itemsize for _, kind, shape in heads]
        if sum(sizes) > MAX_BYTES:
            raise ValueError(f"more than {MAX_BYTES} bytes")
        packed = content[start + length : -DIGEST_BYTES]
        data = pa.Codec("zstd").decompress(packed, sum(sizes), asbytes=True)
    except (KeyError, TypeError, RecursionError, OSError) as fault:  # OSError: of Arrow
        raise ValueError(f"is none: {fault}") from fault
    if len(data) != sum(sizes):
        raise ValueError("its arrays are of other sizes")
    arrays, at = {}, 0
    for (name, kind, shape), size in zip(heads, sizes, strict=True):
        columns = np.frombuffer(data, np.uint8, size, at).reshape(np.dtype(kind).itemsize, -1)
        arrays[name] = np.ascontiguousarray(columns.T).view(kind).reshape(shape)
        at += size
    return record, arrays


def _head(name: Any, kind: Any, shape: Any) -> tuple[str, str, tuple[int, ...]]:
    """Name, type and shape of an array, checked. Raises TypeError, ValueError."""
    if not isinstance(name, str) or kind not in TYPES:
        raise ValueError(f"an array of type {kind!r}")
    sides = tuple(side for side in shape if isinstance(side, int) and 0 <= side <= MAX_BYTES)
    if len(sides) != len(shape):
        raise ValueError(f"{name}: has no such shape")
    return name, kind, sides
