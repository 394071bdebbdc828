"""Arrays in a file come back as they were; anything else is refused."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pyarrow as pa
import pytest

from scenarios.cache.array_file import HEAD, MAGIC, arrays_from_bytes, arrays_to_bytes

KEY = {"episode": "a", "number": 3}
ARRAYS = {
    "floats": np.array([[0.1, -0.0], [np.nan, np.inf]]),
    "cube": np.arange(8.0).reshape(2, 2, 2),
    "whole": np.array([-1, 2**31 - 1], np.int32),
    "bytes": np.arange(256, dtype=np.uint8),
    "none": np.zeros((0, 2)),
}


def file_of(head: object, packed: bytes) -> bytes:
    text = json.dumps(head).encode()
    content = MAGIC + HEAD.pack(len(text)) + text + packed
    return content + hashlib.sha256(content).digest()


def test_arrays_come_back_bit_for_bit():
    key, arrays = arrays_from_bytes(arrays_to_bytes(KEY, ARRAYS))
    assert key == KEY
    assert [*arrays] == [*ARRAYS]
    for name, array in ARRAYS.items():
        assert arrays[name].dtype == array.dtype
        assert arrays[name].shape == array.shape
        assert arrays[name].tobytes() == array.tobytes()


def test_any_changed_byte_is_refused():
    content = arrays_to_bytes(KEY, ARRAYS)
    for at in range(0, len(content), 7):
        changed = bytearray(content)
        changed[at] ^= 1
        with pytest.raises(ValueError, match=r"checksum|cut short"):
            arrays_from_bytes(bytes(changed))
    for length in (0, 10, len(content) // 2, len(content) - 1):
        with pytest.raises(ValueError, match=r"checksum|cut short"):
            arrays_from_bytes(content[:length])


NOTHING = pa.Codec("zstd").compress(b"12345678", asbytes=True)
HOSTILE = {
    "type": {"key": {}, "arrays": [["a", "|O8", [1]]]},
    "negative": {"key": {}, "arrays": [["a", "<f8", [-1, -1]]]},
    "no number": {"key": {}, "arrays": [["a", "<f8", ["1"]]]},
    "huge": {"key": {}, "arrays": [["a", "<f8", [2**29]]]},
    "overflow": {"key": {}, "arrays": [["a", "<f8", [2**29, 2**29, 2**29]]]},
    "larger than its data": {"key": {}, "arrays": [["a", "<f8", [2]]]},
    "smaller than its data": {"key": {}, "arrays": [["a", "|u1", [7]]]},
    "no arrays": {"key": {}},
    "no key": {"arrays": []},
    "a list": [],
}


@pytest.mark.parametrize("head", HOSTILE.values(), ids=HOSTILE)
def test_a_file_with_a_right_checksum_and_another_content_is_refused(head):
    with pytest.raises(ValueError, match=r".+"):
        arrays_from_bytes(file_of(head, NOTHING))


def test_arrays_of_other_types_are_not_written():
    with pytest.raises(ValueError, match="complex"):
        arrays_to_bytes(KEY, {"a": np.zeros(1, complex)})
