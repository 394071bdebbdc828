"""Steps of a long task, such as frames: counted where they happen, shown by whoever waits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

OnStep = Callable[[], None]
T = TypeVar("T")
_on_step: ContextVar[OnStep | None] = ContextVar("on_step", default=None)


def step() -> None:
    """Count a step of the task that runs here; nothing where nobody counts."""
    on_step = _on_step.get()
    if on_step is not None:
        on_step()


def counted(items: Iterable[T]) -> Iterator[T]:
    """Yield the items; each is a step once the next is asked for."""
    for item in items:
        yield item
        step()


@contextmanager
def counting(on_step: OnStep) -> Iterator[None]:
    """Call `on_step` for each step inside the block, in this thread."""
    before = _on_step.set(on_step)
    try:
        yield
    finally:
        _on_step.reset(before)
