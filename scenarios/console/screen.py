"""Whether a console is a screen: something that has a width and can be redrawn."""

from __future__ import annotations

from rich.console import Console


def is_screen(console: Console) -> bool:
    """Whether it is a terminal; a log is none, whatever colours it is made to have."""
    return bool(console.file.isatty()) and not console.is_dumb_terminal
