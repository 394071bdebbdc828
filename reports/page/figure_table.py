"""Tables of figures on a page: columns that are always shown, and those that "more" opens.

Each column knows how to read its cell from a record, so that heads, cells and the labels of a
phone's cards stay together. `table.html.j2` draws them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from reports.summary.groups import GroupRow
from reports.summary.tables import SummaryRow
from reports.summary.text import count, number, percent

Row = TypeVar("Row")
NOTHING = "–"


@dataclass(frozen=True)
class Cell:
    """A figure as text, and the number that sorts it.

    note: small text behind it; share: 0-1 of a bar under it, None for no bar; bad: it is a failure.
    """

    text: str
    value: float | None = None
    note: str = ""
    share: float | None = None
    bad: bool = False


@dataclass(frozen=True)
class Column(Generic[Row]):
    """A column; extra: shown where the reader asks for more; words: its head."""

    words: str
    cell: Callable[[Row], Cell]
    extra: bool = False


@dataclass(frozen=True)
class FigureRow:
    """A row of a table. name: its head; anchor: of the section that the name leads to, or "";
    run: its run, "" where the table is of one run; dot: target whose sign stands before the name.
    """

    name: str
    cells: tuple[Cell, ...]
    anchor: str = ""
    run: str = ""
    dot: str = ""
    pooled: bool = False


@dataclass(frozen=True)
class FigureTable:
    """A table of figures.

    anchor: its id; label: for readers who do not see it; first: head of the names; columns: (words,
    extra) of each; total: rows at the foot.
    """

    anchor: str
    label: str
    first: str
    columns: tuple[tuple[str, bool], ...]
    rows: tuple[FigureRow, ...]
    total: tuple[FigureRow, ...] = ()

    @property
    def runs(self) -> bool:
        """Whether rows of several runs stand in it."""
        return any(row.run for row in (*self.rows, *self.total))

    @property
    def extra(self) -> int:
        """How many columns "more" opens."""
        return sum(extra for _, extra in self.columns)


def heads(columns: Sequence[Column[Row]]) -> tuple[tuple[str, bool], ...]:
    """The heads of columns."""
    return tuple((column.words, column.extra) for column in columns)


def cells(columns: Sequence[Column[Row]], row: Row) -> tuple[Cell, ...]:
    """The cells of a row."""
    return tuple(column.cell(row) for column in columns)


def _figure(value: float, note: str = "") -> Cell:
    """A number with three digits, a dash where there is nothing to measure."""
    return Cell(number(value) if value == value else NOTHING, value, note)


def _within(share: float) -> Cell:
    if share != share:
        return Cell(NOTHING, share)
    return Cell(percent(share), share, share=share)


def _merged(share: float, frames: int) -> Cell:
    return Cell(percent(share), share, f"of {frames}") if frames else Cell(NOTHING)


def _ratio(value: float) -> Cell:
    """A measure of which 1 is best."""
    return Cell(f"{value:.3f}" if value == value else NOTHING, value)


def _episodes(happened: int | None, episodes: int) -> Cell:
    if happened is None:
        return Cell(NOTHING)
    return Cell(f"{happened} of {episodes}", happened, bad=happened > 0)


def _stated(row: GroupRow) -> Cell:
    if not row.exchange_frames:
        return Cell(NOTHING)
    stated = percent(row.exchange_stated).removesuffix(" %")
    return Cell(f"{stated} / {percent(row.exchange_observed)}", row.exchange_observed)


GROUP_COLUMNS: tuple[Column[GroupRow], ...] = (
    Column("Within 100 mm", lambda r: _within(r.within_100)),
    Column("Median mm", lambda r: _figure(r.median_mm)),
    Column("Hands swapped", lambda r: _episodes(r.swapped, r.episodes)),
    Column("A target lost", lambda r: _episodes(r.lost, r.episodes)),
    Column("Group", lambda r: Cell(r.group), extra=True),
    Column(
        "Episodes",
        lambda r: Cell(
            str(r.episodes), r.episodes, f"{r.failed} without result" if r.failed else ""
        ),
        extra=True,
    ),
    Column("90 % below mm", lambda r: _figure(r.p90_mm), extra=True),
    Column(
        "Merged: within 100 mm",
        lambda r: _merged(r.merged_within_100, r.merged_frames),
        extra=True,
    ),
    Column("Merged: median mm", lambda r: _figure(r.merged_median_mm), extra=True),
    Column("Err_acc px", lambda r: _figure(r.err_acc_px), extra=True),
    Column("NEES", lambda r: _figure(r.nees), extra=True),
    Column("MOTA", lambda r: _ratio(r.mota), extra=True),
    Column("IDF1", lambda r: _ratio(r.idf1), extra=True),
    Column("HOTA", lambda r: _ratio(r.hota), extra=True),
    Column("GOSPA mm", lambda r: _figure(r.gospa_mm), extra=True),
    Column("Exchanged: stated / seen", _stated, extra=True),
    Column(
        "Redrawn seeds",
        lambda r: Cell(str(r.redrawn), r.redrawn, count(r.redraws, "draw") if r.redraws else ""),
        extra=True,
    ),
)

TARGET_COLUMNS: tuple[Column[SummaryRow], ...] = (
    Column("Within 100 mm", lambda r: _within(r.within_100)),
    Column("Median mm", lambda r: _figure(r.median_mm)),
    Column("Ever swapped", lambda r: _episodes(r.swapped, r.episodes)),
    Column("Ever lost", lambda r: _episodes(r.lost, r.episodes)),
    Column("Ever captured", lambda r: _episodes(r.captured, r.episodes), extra=True),
    Column("90 % below mm", lambda r: _figure(r.p90_mm), extra=True),
    Column("Err_acc px", lambda r: _figure(r.err_acc_px), extra=True),
    Column("Within 50 mm", lambda r: _within(r.within_50), extra=True),
    Column(
        "Merged: within 100 mm",
        lambda r: _merged(r.merged_within_100, r.merged_frames),
        extra=True,
    ),
    Column(
        "Frames",
        lambda r: Cell(
            str(r.frames),
            r.frames,
            f"{r.frames - r.covered} without estimate" if r.covered < r.frames else "",
        ),
        extra=True,
    ),
)
