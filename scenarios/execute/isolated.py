"""Somebody else's code in a process of its own: what hangs or ends it becomes one line."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from pjpdaf.errors import BenchError
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.plugins.scenes import cameras_in_front
from pjpdaf.presets.registry import PRESETS
from sim.processes import Lost, Workers

BUILD_LIMIT_S = 120.0  # imports of large libraries included
R = TypeVar("R")


class Ended(BenchError):
    """A process that gave no answer: it was ended, or ended itself."""


def isolated(what: str, limit_s: float, function: Callable[..., R], *arguments: Any) -> R:
    """`function(*arguments)` in a new process.

    Raises Ended where it gives no answer within limit_s or ends the process, and the BenchError
    that it raises itself.
    """
    with Workers(1) as workers:
        outcomes = workers.outcomes(_answer, {0: (function, arguments)}, limit_s, attempts=1)
        said = next(found for found in outcomes if found is not None)[1]
    if isinstance(said, Lost):
        if said.late:
            raise Ended(f"The {what} gives no answer within {limit_s:g} s.")
        raise Ended(
            f"The {what} ends the interpreter (exit code {said.exit_code}); it must raise instead."
        )
    if isinstance(said.value, BenchError):
        raise said.value
    answer: R = said.value
    return answer


def _answer(work: tuple[Callable[..., R], tuple[Any, ...]]) -> R | BenchError:
    function, arguments = work
    try:
        return function(*arguments)
    except BenchError as fault:
        return fault


def allow_plug_ins_from_here(*names: str) -> None:
    """Let a module:factory among `names` lie in the current folder.

    The folder comes last on the path, so that it hides no library.
    """
    here = str(Path.cwd())
    if any(":" in name for name in names) and here not in sys.path:
        sys.path.append(here)


def try_plug_ins(detector: str, tracker: str, limit_s: float = BUILD_LIMIT_S) -> None:
    """Build both once where a fault cannot do harm; those of a preset need no trial.

    Raises BenchError.
    """
    for kind, name in (("detector", detector), ("tracker", tracker)):
        if name not in PRESETS:
            isolated(f"{kind} {name!r}", limit_s, _build, kind, name)


def _build(kind: str, name: str) -> None:
    make = make_detector if kind == "detector" else make_tracker
    make(name, cameras_in_front())
