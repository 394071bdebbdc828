"""Faults that a user can put right; the command line prints them as one line."""

from __future__ import annotations

from pathlib import Path


class BenchError(Exception):
    """A fault of the input: rule, value, choices, remedy, in one line. Exit code 2."""

    exit_code = 2


class InfrastructureError(BenchError):
    """The machine lacks something (OpenGL, disk, a worker that died). Exit code 5."""

    exit_code = 5


class FileError(BenchError):
    """A fault of a file: `file` is its path, `cause` the broken rule, without a final stop.

    The line is "file: cause."; with a line number, "file:number: cause."
    """

    def __init__(self, file: Path | str, cause: str, line_number: int | None = None) -> None:
        place = file if line_number is None else f"{file}:{line_number}"
        super().__init__(f"{place}: {cause}.")
        self.file, self.cause = Path(file), cause
