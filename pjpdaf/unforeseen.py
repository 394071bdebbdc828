"""An exception that nobody foresaw: one line for the user, the traceback in a file."""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
from pathlib import Path

from pjpdaf.printable import printable

EXIT_CODE = 5  # of the machine or of our code: never 1, which is a verdict of `compare`
_TEXT_MAX = 300


def report_unforeseen(fault: BaseException, debug: bool = False) -> int:
    """Write one line about `fault` to standard error and its traceback to a file; the exit code.

    debug: the traceback goes to standard error too.
    """
    whole = "".join(traceback.format_exception(fault))
    if debug:
        sys.stderr.write(printable_lines(whole))
    place = _written(whole)
    kept = f"its traceback is in {place}" if place else "its traceback cannot be written here"
    hint = "" if debug else " (--debug shows it)"
    sys.stderr.write(f"pjpdaf-bench: unforeseen: {describe(fault)}; {kept}{hint}\n")
    return EXIT_CODE


def describe(fault: BaseException) -> str:
    """Describe an exception in one line: type, text, and the file and line that raised it."""
    try:
        text = " ".join(str(fault).split())[:_TEXT_MAX]
    except Exception:  # of a __str__ of somebody's
        text = ""
    last = traceback.extract_tb(fault.__traceback__)[-1:]
    place = f" ({Path(last[0].filename).name}:{last[0].lineno})" if last else ""
    return printable(f"{type(fault).__name__}{': ' if text else ''}{text}{place}")


def printable_lines(text: str) -> str:
    """The text with each of its lines made printable."""
    return "".join(printable(line) + "\n" for line in text.splitlines())


def _written(text: str) -> Path | None:
    """A new file with the text, in the folder of temporary files; None where there is no room."""
    try:
        handle, name = tempfile.mkstemp(prefix="pjpdaf-bench-", suffix=".txt")
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
    except OSError:
        return None
    return Path(name)
