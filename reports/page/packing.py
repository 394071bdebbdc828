"""Bytes inside a page: base64, gzip and data addresses."""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from typing import Any


def base64_text(data: bytes) -> str:
    """Encode bytes as base64: free of anything that could end a script element."""
    return b64encode(data).decode()


def gzip_text(data: bytes) -> str:
    """Compress bytes with gzip, the same bytes every time, and encode them as base64."""
    return base64_text(gzip.compress(data, 9, mtime=0))


def json_text(value: Any) -> str:
    """Pack plain values as JSON in gzip in base64. Raises ValueError for NaN and infinity."""
    return gzip_text(json.dumps(value, separators=(",", ":"), allow_nan=False).encode())


def data_address(media_type: str, data: bytes) -> str:
    """The `data:` address of bytes of this media type."""
    return f"data:{media_type};base64,{base64_text(data)}"
