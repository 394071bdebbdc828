"""Tables on a terminal and in a log: no cell is ever cut, no word broken.

A terminal that is too narrow gets the rows as lists; a pipe or a log, which has no width, the table
as wide as it is.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Sequence
from copy import copy

from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

from scenarios.console.lines import print_line
from scenarios.console.screen import is_screen

INDENT = "  "
_HELD = "\u00a0"  # a space at which a line does not end


def print_table(table: Table, console: Console | None = None, wider: Table | None = None) -> None:
    """Print a table whose cells are texts, and set the widths of its columns.

    wider: the same rows with more columns; printed in its stead on a terminal that has the room.
    """
    console = Console() if console is None else console
    if wider is not None and is_screen(console) and _natural(wider, console) <= console.width:
        table = wider
    title, caption = table.title, table.caption
    table.title = table.caption = None
    longest = _widths(table, _longest_line)
    natural = _natural(table, console)
    wide = console if is_screen(console) else Console(file=console.file, width=natural)
    room = wide.width - (natural - sum(longest))
    needed = _widths(table, _longest_word)
    if title is not None:
        console.print(title, highlight=False, soft_wrap=True)
    if sum(needed) <= room:
        for column, width in zip(table.columns, _shared(needed, longest, room), strict=True):
            column.width = width
        wide.print(table)
    else:
        for line in _rows(table, console.width):
            console.print(line, highlight=False, soft_wrap=True)
    if caption is not None:
        print_line(str(caption), console, "dim")


def _natural(table: Table, console: Console) -> int:
    """The columns that a table takes where there is room; its title may be longer."""
    bare = copy(table)
    bare.title = bare.caption = None
    return Measurement.get(console, console.options.update(max_width=10_000), bare).maximum


def _shared(needed: Sequence[int], longest: Sequence[int], room: int) -> list[int]:
    """Give each column what it needs, and of the rest as much as it can use of its share."""
    spare = room - sum(needed)
    wishes = [most - least for most, least in zip(longest, needed, strict=True)]
    if sum(wishes) <= spare:
        return list(longest)
    return [least + wish * spare // sum(wishes) for least, wish in zip(needed, wishes, strict=True)]


def _rows(table: Table, columns: int) -> Iterator[Text]:
    """Yield each row as its first cell, and below it the others with their headings."""
    headings = [" ".join(_plain(column.header).split()) for column in table.columns]
    for row, *cells in zip(table.rows, *(column.cells for column in table.columns), strict=True):
        first, *others = map(_plain, cells)
        pairs = [
            f"{heading}: {cell}".replace(" ", _HELD)
            for heading, cell in zip(headings[1:], others, strict=True)
            if cell
        ]
        if first:
            yield Text(first, style=row.style or "bold")
        for line in textwrap.wrap(
            ", ".join(pairs),
            columns,
            initial_indent=INDENT,
            subsequent_indent=INDENT,
            break_long_words=False,
            break_on_hyphens=False,
        ):
            yield Text(line.replace(_HELD, " "))


def _widths(table: Table, width_of: Callable[[Column, str], int]) -> list[int]:
    return [
        max(width_of(column, _plain(cell)) for cell in (column.header, *column.cells))
        for column in table.columns
    ]


def _longest_line(column: Column, cell: str) -> int:
    return max(map(len, cell.split("\n")))


def _longest_word(column: Column, cell: str) -> int:
    """The width without which a cell would be cut, or a word of it broken."""
    return max(map(len, cell.split("\n") if column.no_wrap else cell.split()), default=0)


def _plain(cell: object) -> str:
    """What is printed of a cell: in a string that is no Text, mark-up is read as such."""
    return cell.plain if isinstance(cell, Text) else Text.from_markup(str(cell)).plain
