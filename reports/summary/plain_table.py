"""The look of all tables for the terminal: a line below the headings, no frame."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text


def plain_table(title: str = "") -> Table:
    """An empty table. title: printed as it is, never as mark-up; none without."""
    return Table(
        title=Text(title) if title else None,
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        show_edge=False,
    )
