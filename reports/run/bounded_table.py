"""Reading a Parquet table of unknown origin: bounded before anything of it is unpacked."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from pjpdaf.errors import BenchError

MAX_BYTES = 256 << 20  # of a file
MAX_CELLS = 32_000_000  # numbers and texts: 5000 episodes of 54 frames have 30 million
MAX_TEXT_BYTES = 256 << 20  # unpacked, of a column
MAX_PAGE_BYTES = 512 << 20  # as stored, without compression


def read_bounded(path: Path, schema: pa.Schema, version: int) -> pa.Table:
    """Read a table of exactly this schema, of a run of this version. Raises BenchError."""
    texts = [column.name for column in schema if pa.types.is_string(column.type)]
    try:
        if path.stat().st_size > MAX_BYTES:
            raise BenchError(f"{path}: is larger than {MAX_BYTES >> 20} MiB.")
        with pq.ParquetFile(path) as file:
            _check_schema(path, file.schema_arrow, schema, version)
            _check_sizes(path, file.metadata)
        # Texts as words of a dictionary: a long one repeated a million times stays small.
        with pq.ParquetFile(path, read_dictionary=texts) as file:
            table = file.read()
        for name in texts:
            _check_text(path, name, table.column(name))
        whole: pa.Table = table.cast(schema).replace_schema_metadata()
        whole.validate(full=True)
    except (OSError, ValueError, MemoryError, OverflowError, pa.ArrowException) as fault:
        cause = " ".join(str(fault).split()).rstrip(".")[:300]
        raise BenchError(f"{path}: is damaged: {cause}.") from fault
    return whole


def _check_schema(path: Path, stored: pa.Schema, schema: pa.Schema, version: int) -> None:
    if not stored.equals(schema):
        odd = sorted({*schema.names} ^ {*stored.names}) or ["types"]
        listed = ", ".join(name[:60] for name in odd[:9])
        raise BenchError(f"{path}: has other columns than schema {version}: {listed}.")


def _check_sizes(path: Path, metadata: pq.FileMetaData) -> None:
    groups = [metadata.row_group(i) for i in range(metadata.num_row_groups)]
    chunks = [group.column(j) for group in groups for j in range(metadata.num_columns)]
    if sum(chunk.num_values for chunk in chunks) > MAX_CELLS:
        raise BenchError(f"{path}: has more than {MAX_CELLS} cells.")
    if sum(chunk.total_uncompressed_size for chunk in chunks) > MAX_PAGE_BYTES:
        raise BenchError(f"{path}: is larger than {MAX_PAGE_BYTES >> 20} MiB unpacked.")


def _check_text(path: Path, name: str, column: pa.ChunkedArray) -> None:
    size = 0
    for chunk in column.chunks:
        lengths = pc.binary_length(chunk.dictionary.cast(pa.binary()))
        size += pc.sum(lengths.take(chunk.indices)).as_py() or 0
    if size > MAX_TEXT_BYTES:
        raise BenchError(f"{path}: column {name!r} has more than {MAX_TEXT_BYTES >> 20} MiB.")
