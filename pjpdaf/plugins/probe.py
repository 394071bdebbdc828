"""Calls of a user's code with a time limit, and the list of its faults."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from pjpdaf.errors import BenchError
from pjpdaf.plugins.loading import NoSuchPlugIn, describe_exception
from pjpdaf.plugins.registry import Factory
from pjpdaf.plugins.scenes import cameras_in_front


class CheckEnds(Exception):
    """A fault after which other checks would only repeat it; its text is the fault's line."""


class Probe:
    """Calls methods of a plug-in and collects faults, each a line: the call, then the fault.

    limit_s: time that a call may take [s]. A call that hangs leaves its thread behind.
    """

    def __init__(self, limit_s: float) -> None:
        self.limit_s = limit_s
        self.faults: list[str] = []

    def run(self, check: Callable[[Probe], None]) -> tuple[str, ...]:
        """Return the faults of a check, each once, in order."""
        try:
            check(self)
        except CheckEnds as end:
            self.faults.append(str(end))
        return tuple(dict.fromkeys(self.faults))

    def call(self, label: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return the function's value.

        Raises CheckEnds where it raises or does not return in time; NoSuchPlugIn as it is.
        """
        values: list[Any] = []
        raised: list[BaseException] = []

        def work() -> None:
            try:
                values.append(function(*arguments))
            except BaseException as fault:
                raised.append(fault)

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        thread.join(self.limit_s)
        if thread.is_alive():
            raise CheckEnds(f"{label}: has not returned after {self.limit_s:g} s")
        if raised:
            if isinstance(raised[0], NoSuchPlugIn):
                raise raised[0]
            if isinstance(raised[0], BenchError):
                raise CheckEnds(" ".join(str(raised[0]).split()))
            raise CheckEnds(f"{label}: raises {describe_exception(raised[0])}")
        return values[0]

    def build(self, factory: Factory, methods: tuple[str, ...]) -> Any:
        """Return the plug-in that the factory makes for `cameras_in_front`.

        Raises CheckEnds where it lacks one of the methods.
        """
        plug_in = self.call("factory(cameras)", factory, cameras_in_front())
        missing = [name for name in methods if not callable(getattr(plug_in, name, None))]
        if missing:
            raise CheckEnds(f"lacks {', '.join(missing)} (pjpdaf.interfaces)")
        return plug_in

    def add(self, label: str, fault: str) -> None:
        """Note a fault of a call."""
        self.faults.append(f"{label}: {fault}")

    def end_at(self, label: str, fault: str) -> None:
        """Raise CheckEnds if there is a fault ("" is none)."""
        if fault:
            raise CheckEnds(f"{label}: {fault}")
