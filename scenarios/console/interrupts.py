"""Signals that end a long verb: Ctrl-C (INT), TERM of a cancelled job, HUP of a closed terminal."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from pjpdaf.errors import BenchError

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Interrupted(BenchError):
    """A verb that a signal ended; its line says what is kept."""

    exit_code = 130


class Interrupts:
    """Signals that arrived since `interrupts` began.

    They are only counted, so that saving goes on undisturbed, but for those inside `raising`.
    """

    def __init__(self) -> None:
        self.count = 0
        self._raise_at: int | None = None

    @property
    def arrived(self) -> bool:
        """Whether the work is to end."""
        return self.count > 0

    @contextmanager
    def raising(self, at: int = 1) -> Iterator[None]:
        """Raise KeyboardInterrupt inside the block when the `at`-th signal of all arrives.

        Once only: whatever the block then does to end itself is not disturbed by further signals.
        """
        before, self._raise_at = self._raise_at, at
        try:
            self._raise_if_due()
            yield
        finally:
            self._raise_at = before

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.count += 1
        self._raise_if_due()

    def _raise_if_due(self) -> None:
        if self._raise_at is not None and self.count >= self._raise_at:
            self._raise_at = None
            raise KeyboardInterrupt


@contextmanager
def interrupts() -> Iterator[Interrupts]:
    """Handle `SIGNALS` inside the block; the handlers before it are restored at its end.

    A signal that the parent shell ignores (`nohup`, a job in the background) stays ignored. In a
    thread other than the main one nothing is handled: Python has signals in the main thread only.
    """
    arrived = Interrupts()
    before = {}
    if threading.current_thread() is threading.main_thread():
        before = {number: signal.getsignal(number) for number in SIGNALS}
    handled = [n for n, handler in before.items() if handler not in (signal.SIG_IGN, None)]
    try:
        for number in handled:
            signal.signal(number, arrived._on_signal)
        yield arrived
    finally:
        for number in handled:
            signal.signal(number, before[number])


@contextmanager
def unwritten_if_interrupted(path: Path, remedy: str = "") -> Iterator[None]:
    """End the block at the first signal.

    Raises Interrupted, which says that `path` is missing; remedy: the end of that line.
    """
    with interrupts() as arrived:
        try:
            with arrived.raising():
                yield
        except KeyboardInterrupt:
            raise Interrupted(f"interrupted: {path} is not written{remedy}") from None
