"""Parquet files of unknown origin: bounded before anything of them is unpacked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

MAX_BYTES = 256 << 20  # of a file
MAX_CELLS = 32_000_000  # numbers and texts: 5000 episodes of 54 frames have 30 million
MAX_TEXT_BYTES = 256 << 20  # unpacked, of a column
MAX_PAGE_BYTES = 512 << 20  # as stored, without compression


class TooLarge(ValueError):
    """A table that is larger than the limits; the message goes after the file's name."""


def read_bounded(path: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """Read columns of a Parquet file; None: all.

    Raises TooLarge, ValueError, OSError and pa.ArrowException.
    """
    if path.stat().st_size > MAX_BYTES:
        raise TooLarge(f"is larger than {MAX_BYTES >> 20} MiB")
    with pq.ParquetFile(path) as file:
        stored = file.schema_arrow
        _check_sizes(file.metadata)
    names = stored.names if columns is None else list(columns)
    fields = [stored.field(name) for name in names]
    texts = [field.name for field in fields if _is_text(field.type)]
    # Texts as words of a dictionary: a long text repeated a million times stays small.
    with pq.ParquetFile(path, read_dictionary=texts) as file:
        table = file.read(columns=names)
    for name in texts:
        _check_text(name, table.column(name))
    whole: pa.Table = table.select(names).cast(pa.schema(fields)).replace_schema_metadata()
    whole.validate(full=True)
    return whole


def _is_text(kind: pa.DataType) -> bool:
    if pa.types.is_dictionary(kind):
        kind = kind.value_type
    return bool(
        pa.types.is_string(kind)
        or pa.types.is_large_string(kind)
        or pa.types.is_binary(kind)
        or pa.types.is_large_binary(kind)
    )


def _check_sizes(metadata: pq.FileMetaData) -> None:
    groups = [metadata.row_group(i) for i in range(metadata.num_row_groups)]
    chunks = [group.column(j) for group in groups for j in range(group.num_columns)]
    if sum(chunk.num_values for chunk in chunks) > MAX_CELLS:
        raise TooLarge(f"has more than {MAX_CELLS} cells")
    if sum(chunk.total_uncompressed_size for chunk in chunks) > MAX_PAGE_BYTES:
        raise TooLarge(f"is larger than {MAX_PAGE_BYTES >> 20} MiB unpacked")


def _check_text(name: str, column: pa.ChunkedArray) -> None:
    import pyarrow.compute as pc  # late: it takes a thirtieth of a command's start

    size = 0
    for chunk in column.chunks:
        lengths = pc.binary_length(chunk.dictionary.cast(pa.binary()))
        size += pc.sum(lengths.take(chunk.indices)).as_py() or 0
    if size > MAX_TEXT_BYTES:
        raise TooLarge(f"has more than {MAX_TEXT_BYTES >> 20} MiB in column {name[:60]!r}")
