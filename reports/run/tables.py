"""Arrow tables of a run, and their Parquet files with every option fixed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from reports.run.rows import EpisodeRows
from reports.run.schema import (
    CAMERAS,
    DETECTIONS,
    EPISODES,
    EVENTS,
    FRAMES,
    TRACKING,
)

ROW_GROUP = 65536


def tables_of(rows: Sequence[EpisodeRows]) -> dict[str, pa.Table]:
    """Build the tables of a run by name, rows in a fixed order whatever the order of episodes."""
    ordered = sorted(rows, key=lambda r: (r.scenario, r.seed))
    frames = pa.table(
        {name: [v for r in ordered for v in r.frames[name]] for name in FRAMES.names}, schema=FRAMES
    )
    episodes = [row for r in ordered for row in r.episodes]
    events = [row for r in ordered for row in r.events]
    tracking = [r.tracking for r in ordered if r.tracking is not None]
    cameras = [row for r in ordered for row in r.cameras]
    detections = {
        name: [v for r in ordered for v in r.detections.get(name, [])] for name in DETECTIONS.names
    }
    return {
        "frames": frames,
        "episodes": pa.Table.from_pylist(episodes, schema=EPISODES),
        "events": pa.Table.from_pylist(events, schema=EVENTS),
        "tracking": pa.Table.from_pylist(tracking, schema=TRACKING),
        "detections": pa.table(detections, schema=DETECTIONS),
        "cameras": pa.Table.from_pylist(cameras, schema=CAMERAS),
    }


def write_table(path: Path, table: pa.Table, *, packed: bool = False) -> None:
    """Write a table as Parquet with every option fixed, so that equal tables are equal files.

    packed: a fifth smaller, in an encoding of numbers that some older readers lack.
    """
    numbers = [c.name for c in table.schema if pa.types.is_floating(c.type)]
    others = [name for name in table.schema.names if name not in numbers]
    pq.write_table(
        table,
        path,
        version="2.6",
        data_page_version="1.0",
        compression="zstd",
        compression_level=6,
        use_dictionary=others if packed else True,
        use_byte_stream_split=numbers if packed else False,
        write_statistics=True,
        row_group_size=ROW_GROUP,
    )
