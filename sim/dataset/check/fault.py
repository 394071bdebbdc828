"""Faults of a data set, each named with its file, and the log that collects them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from pjpdaf.errors import FileError

MISSING = "missing"
T = TypeVar("T")


@dataclass(frozen=True, order=True)
class Fault:
    """A fault of a file. file: path relative to the data set's folder; text: one line.

    check: name of the check that reports it; two checks may report the same fault.
    """

    file: str
    text: str
    check: str = field(default="", compare=False)

    def __str__(self) -> str:
        # Names of files come from strangers; a terminal obeys some characters.
        return "".join(c if c.isprintable() else "?" for c in f"{self.file}: {self.text}")


@dataclass(frozen=True)
class FrameFault:
    """A fault of one frame in a file of a whole sequence.

    kind: the faulty quantity, such as "box of head, left view"; text: the fault in this frame.
    """

    file: str
    kind: str
    frame: int
    text: str
    check: str = ""


class FaultLog:
    """Collects the faults of a data set. root: its folder."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.faults: list[Fault] = []
        self._frame_faults: list[FrameFault] = []

    def add(self, check: str, faults: Iterable[Fault | FrameFault]) -> bool:
        """Record faults under a check's name; True if a whole file is faulty (`Fault`)."""
        whole_file = False
        for fault in faults:
            if isinstance(fault, Fault):
                self.faults.append(replace(fault, check=check))
                whole_file = True
            else:
                self._frame_faults.append(replace(fault, check=check))
        return whole_file

    def read(self, read: Callable[[], T]) -> T | None:
        """The result of a reader, or None where it raises FileError, which becomes a fault."""
        try:
            return read()
        except FileError as error:
            self.faults.append(fault_of(error, self.root))
            return None

    def all(self) -> tuple[Fault, ...]:
        """All faults, those of frames gathered."""
        return (*self.faults, *gathered(self._frame_faults))


def fault_of(error: FileError, root: Path) -> Fault:
    """The fault of a file below root that a reader refused."""
    file = error.file.relative_to(root).as_posix()
    # Each reader has other words for a missing file.
    return Fault(file, error.cause if error.file.exists() else MISSING, "reading")


def gathered(frame_faults: Iterable[FrameFault]) -> list[Fault]:
    """A fault per file and kind: the text of its first frame, and the number of other frames."""
    kinds: dict[tuple[str, str], list[FrameFault]] = {}
    for fault in frame_faults:
        kinds.setdefault((fault.file, fault.kind), []).append(fault)
    faults = []
    for (file, kind), group in kinds.items():
        first = min(group, key=lambda fault: fault.frame)
        frames = len({fault.frame for fault in group})
        more = f" (and in {frames - 1} more frames)" if frames > 1 else ""
        text = f"{kind}: frame {first.frame}: {first.text}{more}"
        faults.append(Fault(file, text, first.check))
    return faults
