"""Reading a table of a saved run of unknown origin."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.errors import BenchError
from sim.parquet import TooLarge, read_bounded


def read_table(path: Path, schema: pa.Schema, version: int) -> pa.Table:
    """Read a table of exactly this schema, of a run of this version. Raises BenchError."""
    try:
        stored = pq.read_schema(path)
        if not stored.equals(schema):
            odd = sorted({*schema.names} ^ {*stored.names}) or ["types"]
            listed = ", ".join(name[:60] for name in odd[:9])
            raise BenchError(f"{path}: has other columns than schema {version}: {listed}.")
        return read_bounded(path)
    except TooLarge as fault:
        raise BenchError(f"{path}: {fault}.") from None
    except (OSError, ValueError, MemoryError, OverflowError, pa.ArrowException) as fault:
        cause = " ".join(str(fault).split()).rstrip(".")[:300]
        raise BenchError(f"{path}: is damaged: {cause}.") from fault
