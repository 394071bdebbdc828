"""Plug-in code in a process of its own: code that hangs or ends the process becomes one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from pjpdaf.errors import BenchError
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.plugins.scenes import cameras_in_front
from pjpdaf.presets.registry import PRESETS
from sim.processes import Answer, WorkerPool

BUILD_LIMIT_S = 120.0  # imports of large libraries included
R = TypeVar("R")


class Ended(BenchError):
    """A process that gave no answer: it was ended, or ended itself."""


def isolated(subject: str, limit_s: float, function: Callable[..., R], *arguments: Any) -> R:
    """Call `function(*arguments)` in a new process; its value.

    subject: what the code belongs to, for messages, such as "tracker 'mine:make'". Raises Ended
    where the process gives no answer within limit_s or ends, and what the function raises.
    """
    with WorkerPool(1) as pool:
        outcomes = pool.outcomes(_call, {0: (function, arguments)}, limit_s, attempts=1)
        outcome = next(indexed for indexed in outcomes if indexed is not None)[1]
    if isinstance(outcome, Answer):
        value: R = outcome.value
        return value
    if outcome.late:
        raise Ended(f"The {subject} gives no answer within {limit_s:g} s.")
    raise Ended(
        f"The {subject} ends the interpreter (exit code {outcome.exit_code}); it must raise "
        "instead."
    )


def _call(work: tuple[Callable[..., R], tuple[Any, ...]]) -> R:
    function, arguments = work
    return function(*arguments)


def try_plug_ins(detector: str | None, tracker: str, limit_s: float = BUILD_LIMIT_S) -> None:
    """Build plug-ins once in a process of their own; a preset needs no trial. Raises BenchError.

    detector: None where detections come from files.
    """
    for kind, name in (("detector", detector), ("tracker", tracker)):
        if name is not None and name not in PRESETS:
            isolated(f"{kind} {name!r}", limit_s, _build, kind, name)


def _build(kind: str, name: str) -> None:
    make = make_detector if kind == "detector" else make_tracker
    make(name, cameras_in_front())
