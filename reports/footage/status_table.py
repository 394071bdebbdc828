"""The summary of footage for the terminal."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from pjpdaf.interfaces import STATUSES
from reports.footage.stated import SURE_M
from reports.footage.track_record import TrackRecord
from reports.summary.plain_table import plain_table
from reports.summary.text import percent
from reports.words import LABELS


def status_table(record: TrackRecord) -> Table:
    """A row per target: shares of each status, gaps, stated standard deviations."""
    table = plain_table()
    table.add_column("target", no_wrap=True)
    for status in STATUSES[1:]:
        table.add_column(status, justify="right", no_wrap=True)
    most = f"{1000 * SURE_M:.0f} mm"
    headings = ("waiting\nframes", "longest\ngap", "sd mm\nmedian", "sd mm\n90 %", f"sd to\n{most}")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for summary in record.summaries():
        stated = summary.stated
        table.add_row(
            LABELS[summary.target],
            *(f"{100 * summary.shares[status]:.1f} %" for status in STATUSES[1:]),
            str(summary.frames["waiting"]),
            f"{summary.longest_gap_s:.1f} s",
            *("-" if np.isnan(v) else f"{v:.0f}" for v in (stated.median_mm, stated.p90_mm)),
            percent(stated.sure),
        )
    return table
