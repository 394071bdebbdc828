"""Lines of text on a terminal and in a log."""

from __future__ import annotations

import textwrap

from rich.console import Console
from rich.text import Text

from scenarios.console.screen import is_screen


def print_line(line: str, console: Console | None = None, style: str = "") -> None:
    """Print a line of text: a terminal breaks it between words, a pipe or a log gets it whole.

    No word is broken, not even a path longer than the terminal is wide, and `line` has no mark-up.
    """
    console = Console() if console is None else console
    if is_screen(console):
        line = textwrap.fill(
            line,
            console.width,
            subsequent_indent=" " * (len(line) - len(line.lstrip())),
            break_long_words=False,
            break_on_hyphens=False,
        )
    print_command(line, console, style)


def print_command(line: str, console: Console, style: str = "") -> None:
    """Print a line that is made to be copied: no line ends in it but where the terminal is full."""
    console.print(Text(line, style=style), highlight=False, soft_wrap=True)
