"""Reads JSON and Parquet files of unknown origin: bounded in size, inside their folder."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.errors import FileError

MAX_JSON_BYTES = 256 << 20
MAX_ROWS = 10_000_000
MAX_TABLE_BYTES = 8 << 30  # unpacked


def check_inside(folder: Path, path: Path) -> None:
    """Raise FileError unless a path is a plain file in a folder, links followed."""
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(folder)):
        raise FileError(
            path,
            "is a link that leads out of the data set; copy it with its links followed (cp -rL)",
        )
    if not Path(real).exists():
        raise FileError(path, "is missing")
    if not Path(real).is_file():
        raise FileError(path, "is not a file")


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object. Raises FileError for anything else."""
    try:
        if path.stat().st_size > MAX_JSON_BYTES:
            raise FileError(path, f"is larger than {MAX_JSON_BYTES >> 20} MiB")
        record = json.loads(path.read_text(encoding="utf-8"))
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror}") from fault
    except (ValueError, RecursionError) as fault:
        raise FileError(path, f"is not JSON: {fault}") from fault
    if not isinstance(record, dict):
        raise FileError(path, "is not a JSON object")
    return record


def read_table(
    path: Path, schema: pa.Schema, wanted: str = "", rows: int | None = None
) -> pa.Table:
    """Read the columns of a schema from a Parquet file, which may have more.

    rows: their required number; wanted: the same in words. Raises FileError for a damaged file or
    another number.
    """
    try:
        with pq.ParquetFile(path) as file:
            metadata = file.metadata
            groups = [metadata.row_group(i).total_byte_size for i in range(metadata.num_row_groups)]
            if metadata.num_rows > MAX_ROWS or sum(groups) > MAX_TABLE_BYTES:
                raise FileError(
                    path, f"has more than {MAX_ROWS} rows or {MAX_TABLE_BYTES >> 30} GiB"
                )
            missing = set(schema.names) - set(file.schema_arrow.names)
            if missing:
                raise FileError(path, f"lacks the columns {', '.join(sorted(missing))}")
            if rows is not None and metadata.num_rows != rows:
                raise FileError(path, f"must have {wanted}, has {metadata.num_rows}")
            return file.read(columns=schema.names).select(schema.names).cast(schema)
    except FileNotFoundError as fault:
        raise FileError(path, "is missing") from fault
    except (OSError, KeyError, ValueError, pa.ArrowException) as fault:
        cause = str(fault).partition("\n")[0].rstrip(".")
        raise FileError(path, f"cannot be read as Parquet: {cause}") from fault
