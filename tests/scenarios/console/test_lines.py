"""A line in any width: no word of it is broken, nothing of it is read as mark-up."""

import io
import re

import pytest
from rich.console import Console

from scenarios.console.lines import print_command, print_line

PATH = "runs/a-name-that-is-as-long-as-any/and-a-folder-in-it/report.html"
LINE = f"  note: 97 of 100 frames [bold] of set=[0.1,0.7], at 5\N{NO-BREAK SPACE}mm, are in {PATH}"


class Screen(io.StringIO):
    def isatty(self):
        return True


def printed(prints, columns):
    file = io.StringIO() if columns is None else Screen()
    prints(LINE, Console(file=file, width=columns, no_color=True))
    return re.sub(r"\x1b\[[0-9;]*m", "", file.getvalue())


@pytest.mark.parametrize("columns", [30, 80, None])
def test_a_terminal_breaks_it_between_words_and_a_pipe_gets_it_whole(columns):
    lines = printed(print_line, columns).splitlines()
    assert " ".join(line.strip() for line in lines) == LINE.strip()
    assert all(len(line) <= (columns or 999) or line.strip() == PATH for line in lines)
    assert all(line.startswith("  ") for line in lines)
    assert (len(lines) == 1) == (columns is None)
    assert any("5\N{NO-BREAK SPACE}mm," in line for line in lines)


def test_a_command_is_one_line_that_can_be_copied():
    assert printed(print_command, 30) == f"{LINE}\n"
