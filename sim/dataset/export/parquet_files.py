"""Parquet files of bounded size, written a row group at a time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from sim.scene.world import CAMERAS

GROUP_ROWS, GROUP_BYTES = 100, 32 << 20  # of a row group, which is held in memory


class RowStream:
    """Writes rows into a file as an Arrow stream, in batches that fit into memory."""

    def __init__(self, path: Path, schema: pa.Schema) -> None:
        self._schema, self._rows = schema, list[Mapping[str, Any]]()
        self._held_bytes = 0
        self._writer = pa.ipc.new_stream(path, schema)

    def add(self, row: Mapping[str, Any]) -> None:
        """Add a row."""
        self._rows.append(row)
        self._held_bytes += sum(len(row[c]["bytes"]) for c in CAMERAS if row[c] is not None)
        if len(self._rows) >= GROUP_ROWS or self._held_bytes >= GROUP_BYTES:
            self._write()

    def _write(self) -> None:
        if self._rows:
            self._writer.write_table(pa.Table.from_pylist(self._rows, schema=self._schema))
        self._rows, self._held_bytes = [], 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *fault: object) -> None:
        if fault[0] is None:
            self._write()
        self._writer.close()


class ParquetFiles:
    """Writes rows into files; call `finish` after the last row, and close it in any case.

    most_bytes: of pictures, after which the next row group begins a new file.
    """

    def __init__(self, folder: Path, schema: pa.Schema, most_bytes: int) -> None:
        self._folder, self._schema, self._most_bytes = folder, schema, most_bytes
        self._paths: list[Path] = []
        self._writer: pq.ParquetWriter | None = None
        self._held: list[pa.Table] = []
        self._held_rows = self._held_bytes = self._written_bytes = 0

    def add(self, path: Path) -> None:
        """Add the rows of a `RowStream`'s file."""
        with pa.ipc.open_stream(path) as stream:
            for batch in stream:
                self._add_batch(pa.Table.from_batches([batch], self._schema))

    def _add_batch(self, table: pa.Table) -> None:
        """Add rows, and write a row group at each row that completes one."""
        start = 0
        for row, size in enumerate(_picture_bytes(table)):
            self._held_rows += 1
            self._held_bytes += size
            most = min(GROUP_BYTES, self._most_bytes)
            if self._held_rows >= GROUP_ROWS or self._held_bytes >= most:
                self._held.append(table[start : row + 1])
                self._write_group()
                start = row + 1
        if start < len(table):
            self._held.append(table[start:])

    def finish(self) -> None:
        """Write the rows that are held, and name the files, whose number is known only now."""
        if self._held:
            self._write_group()
        self.close()
        for index, path in enumerate(self._paths):
            path.rename(path.with_name(f"frames-{index:05d}-of-{len(self._paths):05d}.parquet"))

    def close(self) -> None:
        """Close the current file."""
        if self._writer is not None:
            self._writer.close()
            self._writer = None

    def _write_group(self) -> None:
        if self._writer is None:
            self._paths.append(self._folder / f"{len(self._paths)}.parquet")
            labels = [name for name in self._schema.names if name not in CAMERAS]
            self._writer = pq.ParquetWriter(
                self._paths[-1],
                self._schema,
                compression="zstd",
                # Pictures are neither alike nor to be compared.
                use_dictionary=labels,
                write_statistics=labels,
            )
            self._written_bytes = 0
        self._writer.write_table(pa.concat_tables(self._held).combine_chunks())
        self._written_bytes += self._held_bytes
        self._held, self._held_rows, self._held_bytes = [], 0, 0
        if self._written_bytes >= self._most_bytes:
            self.close()


def _picture_bytes(table: pa.Table) -> list[int]:
    """Bytes of the pictures of each row."""
    sizes = [
        pc.fill_null(pc.binary_length(pc.struct_field(table[camera], "bytes")), 0)
        for camera in CAMERAS
    ]
    return list(pc.add(*sizes).to_pylist())
