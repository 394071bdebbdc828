"""The summary of footage for the terminal."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table

from pjpdaf.interfaces import STATUSES
from reports.footage.track_record import TrackRecord
from reports.summary.text import LABELS, count


def status_table(record: TrackRecord) -> Table:
    """A row per target: shares of each status, gaps, standard deviations."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("target")
    for status in STATUSES[1:]:
        table.add_column(status, justify="right")
    table.add_column("waiting", justify="right")
    table.add_column("longest gap", justify="right")
    table.add_column("sd x, y, z [mm]", justify="right")
    for summary in record.summaries():
        sd = ", ".join("-" if np.isnan(v) else f"{v:.0f}" for v in summary.sd_mm)
        shares = [f"{100 * summary.shares[status]:.1f} %" for status in STATUSES[1:]]
        waiting = count(summary.frames["waiting"], "frame")
        table.add_row(
            LABELS[summary.target], *shares, waiting, f"{summary.longest_gap_s:.1f} s", sd
        )
    return table
