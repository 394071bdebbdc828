"""Faults that a user can put right; the command line prints them as one line."""

from __future__ import annotations

import difflib
import pickle
from collections.abc import Collection
from pathlib import Path
from typing import Any, Self, TypeVar

from pjpdaf.printable import printable

FEW = 8  # names that a message lists
NEAR = 0.08  # of the closest name's likeness, 0-1: names that may have been meant as well
E = TypeVar("E", bound="BenchError")


class BenchError(Exception):
    """A fault of the input: rule, value, choices, remedy, in one line. Exit code 2.

    It crosses processes: type, line, fields and exit code survive pickling. Where the type or a
    field cannot be pickled, or not be read at the other end, a BenchError of the same line and
    exit code arrives.
    """

    exit_code = 2

    def __str__(self) -> str:
        # Text quoted from a file may hold anything; a fault stays one line, harmless on a terminal.
        return printable(super().__str__())

    def reworded(self, line: str) -> Self:
        """Copy the fault, with its type, fields and exit code, and another line."""
        return _restored(type(self), (line,), self.__dict__)

    def __reduce__(self) -> tuple[Any, ...]:
        try:
            whole = pickle.dumps((type(self), self.args, self.__dict__))
        except Exception:  # pickle raises nearly anything
            whole = b""
        return _unpickled, (whole, str(self), self.exit_code)


class InfrastructureError(BenchError):
    """A fault of the machine (OpenGL, disk, a worker that died). Exit code 5.

    cause: what is wrong; remedy: how to put it right, "" where it is not known.
    """

    exit_code = 5

    def __init__(self, cause: str, remedy: str = "") -> None:
        super().__init__(f"{cause}; {remedy}" if remedy else cause)
        self.cause, self.remedy = cause, remedy


class NotComparable(BenchError):
    """Results of different episodes, or of another version of them. Exit code 4."""

    exit_code = 4


class FileError(BenchError):
    """A fault of a file: `file` is its path, `cause` the broken rule, without a final stop.

    The line is "file: cause."; with a line number, "file:number: cause."
    """

    def __init__(self, file: Path | str, cause: str, line_number: int | None = None) -> None:
        place = file if line_number is None else f"{file}:{line_number}"
        super().__init__(f"{place}: {cause}.")
        self.file, self.cause = Path(file), cause


class PlugInFault(Exception):
    """A plug-in that raised, or whose answer breaks the protocol. One line; ends its episode."""


def _unpickled(whole: bytes, line: str, exit_code: int) -> BenchError:
    if whole:
        try:
            error: BenchError = _restored(*pickle.loads(whole))
            return error
        except Exception:  # a class that is not importable here, a field that cannot be built
            pass
    plain = BenchError(line)
    plain.exit_code = exit_code
    return plain


def _restored(kind: type[E], arguments: tuple[Any, ...], fields: dict[str, Any]) -> E:
    """An error built without `__init__`, whose parameters differ from class to class."""
    error: E = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(fields)
    return error


def closest(name: str, known: Collection[str]) -> list[str]:
    """The known names that `name` may have been meant to be, the closest first; at most three."""
    by_lower = {one.lower(): one for one in sorted(known)}
    near = difflib.get_close_matches(name.lower(), by_lower, n=3, cutoff=0.6)
    best = [_likeness(name, one) for one in near]
    return [by_lower[n] for n, like in zip(near, best, strict=True) if like > best[0] - NEAR]


def _likeness(name: str, other: str) -> float:
    return difflib.SequenceMatcher(None, other, name.lower()).ratio()


def did_you_mean(name: str, known: Collection[str]) -> str:
    """' Did you mean ...?' behind a sentence; all of a few names, or the nearest of many."""
    near = closest(name, known)
    hint = f" Did you mean {' or '.join(map(repr, near))}?" if near else ""
    if len(known) <= FEW:
        return f"{hint} Known: {', '.join(sorted(known))}."
    if near:
        return hint
    nearest = difflib.get_close_matches(name, known, n=3, cutoff=0.0)
    return f" The nearest of {len(known)} are {', '.join(nearest)}."
