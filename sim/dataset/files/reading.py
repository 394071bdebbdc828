"""Reads JSON and Parquet files of unknown origin: bounded in size, inside their folder."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.errors import FileError
from sim.parquet import TooLarge, read_bounded

MAX_JSON_BYTES = 64 << 20


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
            missing = set(schema.names) - set(file.schema_arrow.names)
            if missing:
                raise FileError(path, f"lacks the columns {', '.join(sorted(missing))}")
            if rows is not None and file.metadata.num_rows != rows:
                raise FileError(path, f"must have {wanted}, has {file.metadata.num_rows}")
        return read_bounded(path, schema.names).cast(schema)
    except TooLarge as fault:
        raise FileError(path, str(fault)) from None
    except FileNotFoundError as fault:
        raise FileError(path, "is missing") from fault
    except (OSError, KeyError, ValueError, pa.ArrowException) as fault:
        cause = str(fault).partition("\n")[0].rstrip(".")
        raise FileError(path, f"cannot be read as Parquet: {cause}") from fault
