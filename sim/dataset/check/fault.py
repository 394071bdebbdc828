"""What is wrong with a data set, named with its file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError

_LINE_NUMBER = re.compile(r":\d+$")


@dataclass(frozen=True, order=True)
class Fault:
    """file: path relative to the data set's folder; what: is wrong with it, in one line."""

    file: str
    what: str

    def __str__(self) -> str:
        # Names of files come from strangers; a terminal obeys some characters.
        return "".join(c if c.isprintable() else "?" for c in f"{self.file}: {self.what}")


def fault_of(error: BenchError, root: Path) -> Fault:
    """The fault that a reader raised about a file below root."""
    file, _, what = str(error).removeprefix(f"{root}/").partition(": ")
    return Fault(_LINE_NUMBER.sub("", file), what.removesuffix("."))
