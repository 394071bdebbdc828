"""The summary of footage for the terminal."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table

from pjpdaf.interfaces import STATUSES
from reports.footage.stated import SURE_M
from reports.footage.track_record import TrackRecord
from reports.summary.text import LABELS, count, percent


def status_table(record: TrackRecord) -> Table:
    """A row per target: shares of each status, gaps, stated standard deviations."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("target")
    for status in STATUSES[1:]:
        table.add_column(status, justify="right")
    for heading in ("waiting", "longest\ngap", "stated sd mm\nmedian, 90 %"):
        table.add_column(heading, justify="right")
    table.add_column(f"sd to\n{1000 * SURE_M:.0f} mm", justify="right")
    for summary in record.summaries():
        stated = summary.stated
        sd = ", ".join(
            "-" if np.isnan(v) else f"{v:.0f}" for v in (stated.median_mm, stated.p90_mm)
        )
        shares = [f"{100 * summary.shares[status]:.1f} %" for status in STATUSES[1:]]
        waiting = count(summary.frames["waiting"], "frame")
        gap = f"{summary.longest_gap_s:.1f} s"
        table.add_row(LABELS[summary.target], *shares, waiting, gap, sd, percent(stated.sure))
    return table
