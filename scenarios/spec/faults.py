"""A fault of a file, with its place."""

from __future__ import annotations

from collections.abc import Sequence

from pjpdaf.errors import BenchError

FieldPath = tuple[str | int, ...]  # from a file's top: names of fields, numbers of list items
Position = tuple[int, int]  # line and column, from 1
Positions = dict[FieldPath, Position]  # of a field's name, or of a list's item


class FileFault(BenchError):
    """A broken rule and its place: `file:line:column: path: rule`."""

    def __init__(self, file: str, at: Position | None, message: str) -> None:
        where = file if at is None else f"{file}:{at[0]}:{at[1]}"
        # Text quoted from the file may hold anything; a fault stays one line.
        plain = "".join(c if c.isprintable() else "?" for c in f"{where}: {message}")
        super().__init__(plain)


def dotted(path: Sequence[str | int]) -> str:
    """The path as the beginning of a message, "a.0.b: "; "" for the file's top."""
    return ".".join(str(name)[:60] for name in path) + ": " if path else ""
