"""The protocol of everything that executes tasks: processes of this machine, or a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Protocol, TypeVar

from pjpdaf.errors import InfrastructureError
from sim.processes import ATTEMPTS, Answer, Lost

T = TypeVar("T")
R = TypeVar("R")


class ClusterFault(InfrastructureError):
    """A cluster that does not go on. What is finished is kept."""


class Executor(Protocol):
    """Executes independent tasks in isolated processes; `sim.processes.WorkerPool` is one.

    Functions and tasks are pickled. A process that dies takes no other task with it.
    """

    def outcomes(
        self,
        function: Callable[[T], R],
        tasks: Mapping[int, T],
        limit_s: float,
        attempts: int = ATTEMPTS,
    ) -> Iterator[tuple[int, Answer[R] | Lost] | None]:
        """Yield (index, outcome) of `function(task)` as tasks end, None on each poll.

        limit_s: time limit of one attempt; attempts: of a task whose process dies. Raises what
        `function` raises; then, or where the caller stops early, the tasks that are left are
        dropped.
        """
        ...

    def renderers(self) -> frozenset[str]:
        """Descriptions of the OpenGL renderers of its processes: several on unlike machines.

        Raises InfrastructureError.
        """
        ...

    def running_steps(self) -> int:
        """Steps, such as frames, of the tasks in progress; 0 where that is not known."""
        ...

    def close(self) -> None:
        """End all processes now."""
        ...
