"""Writes the tables of a sequence a group of rows at a time: memory does not grow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sim.dataset.files.layout import OBJECTS, SKELETON, TRUTH
from sim.dataset.files.tables import OBJECTS_SCHEMA, SKELETON_SCHEMA, TRUTH_SCHEMA

ROW_GROUP = 4096  # rows of a table that are held before Parquet takes them
_SCHEMAS = {TRUTH: TRUTH_SCHEMA, OBJECTS: OBJECTS_SCHEMA, SKELETON: SKELETON_SCHEMA}


class TableWriter:
    """The tables of a sequence. writers: by file name."""

    def __init__(self, writers: Mapping[str, pq.ParquetWriter]) -> None:
        self._writers = writers
        self._held: dict[str, list[Mapping[str, Any]]] = {name: [] for name in writers}

    def add(self, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
        """Add rows to the table of this file name."""
        self._held[name] += rows
        if len(self._held[name]) >= ROW_GROUP:
            self._write_group(name)

    def finish(self) -> None:
        """Write the rows that are held."""
        for name, rows in self._held.items():
            if rows:  # a row group without rows is more than some readers bear
                self._write_group(name)

    def _write_group(self, name: str) -> None:
        table = pa.Table.from_pylist(self._held[name], schema=_SCHEMAS[name])
        self._writers[name].write_table(table)
        self._held[name] = []


@contextmanager
def writing_tables(folder: Path) -> Iterator[TableWriter]:
    """A writer of the tables into a folder. Raises OSError of the disk."""
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(pq.ParquetWriter(folder / name, schema, compression="zstd"))
            for name, schema in _SCHEMAS.items()
        }
        tables = TableWriter(writers)
        yield tables
        tables.finish()
