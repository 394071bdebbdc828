"""A table in any width: every word of it is there, whole."""

import io

import pytest
from rich.console import Console
from rich.text import Text

from reports.summary.plain_table import plain_table
from scenarios.console.tables import print_table

NAMES = ("cross", "a_scenario_with-a-very-long-name@12+dim")
VERDICT = "inconclusive"


def table():
    made = plain_table("Run runs/a-long-name-20261126-101336")
    made.add_column("scenario", no_wrap=True)
    made.add_column("within\n100 mm", justify="right", no_wrap=True)
    made.add_column("what it is")
    made.add_column("verdict", no_wrap=True)
    for name in NAMES:
        made.add_row(Text(name), "> 99.9 %", "Hands that cross each other slowly", Text(VERDICT))
    made.caption = Text("1 episode gave no result")
    return made


class Screen(io.StringIO):
    def isatty(self):
        return True


def printed(columns=None, wider=None, **options):
    file = io.StringIO() if columns is None else Screen()
    console = Console(file=file, width=columns, no_color=True, **options)
    print_table(table(), console, wider)
    return Text.from_ansi(console.file.getvalue()).plain


@pytest.mark.parametrize("columns", [40, 60, 80, 120, None])
def test_nothing_is_cut_and_no_word_is_broken(columns):
    text = printed(columns)
    assert "…" not in text
    words = text.replace(",", " ").split()
    for word in (*NAMES, VERDICT, "99.9", "slowly", "Hands"):
        assert word in words
    assert "Run runs/a-long-name-20261126-101336" in text
    assert "1 episode gave no result" in text


@pytest.mark.parametrize(("columns", "more"), [(95, False), (120, True), (None, False)])
def test_more_columns_are_printed_only_where_a_terminal_has_the_room(columns, more):
    wider = table()
    wider.add_column("more")
    for column in wider.columns[-1:]:
        column._cells += ["so much"] * len(NAMES)
    text = printed(columns, wider=wider)
    assert ("so much" in text) == more
    assert "1 episode gave no result" in text
    if columns:
        assert max(map(len, text.splitlines())) <= columns


def test_the_log_of_a_ci_job_that_asks_for_colours_is_no_screen():
    assert printed(None, force_terminal=True) == printed(None)


def test_a_wide_enough_terminal_has_one_line_a_row():
    lines = [line for line in printed(120).splitlines() if VERDICT in line]
    assert [line.split()[0] for line in lines] == list(NAMES)
    assert all("slowly" in line for line in lines)


def test_texts_take_the_lines_that_the_width_needs():
    lines = printed(80).splitlines()
    assert max(map(len, lines)) <= 80
    assert any(line.startswith("cross ") and VERDICT in line for line in lines)


def test_a_narrow_terminal_has_lists():
    lines = printed(60).splitlines()
    assert lines[1] == "cross"
    assert lines[2].startswith("  within 100 mm: > 99.9 %,")
    assert max(map(len, lines)) <= 60
