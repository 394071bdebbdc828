"""What is wrong with a data set, named with its file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError

MISSING = "missing"
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
    file = _LINE_NUMBER.sub("", file)
    if not (root / file).exists():  # each reader has other words for it
        return Fault(file, MISSING)
    return Fault(file, what.removesuffix("."))


@dataclass(frozen=True)
class Claim:
    """A file of a whole sequence that is wrong about a frame. kind: what it says of every frame,
    such as "box of head, left view"; what: is wrong with it there.
    """

    file: str
    kind: str
    frame: int
    what: str


def gathered(claims: Iterable[Claim]) -> list[Fault]:
    """One fault a file and kind, however many frames it is wrong in."""
    kinds: dict[tuple[str, str], list[Claim]] = {}
    for claim in claims:
        kinds.setdefault((claim.file, claim.kind), []).append(claim)
    faults = []
    for (file, kind), found in kinds.items():
        first = min(found, key=lambda claim: claim.frame)
        frames = len({claim.frame for claim in found})
        more = f" (and in {frames - 1} more frames)" if frames > 1 else ""
        faults.append(Fault(file, f"{kind}: frame {first.frame}: {first.what}{more}"))
    return faults
