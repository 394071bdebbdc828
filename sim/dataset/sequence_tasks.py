"""Work on each sequence of a data set, in worker processes; the results come in order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from pjpdaf.errors import InfrastructureError
from sim.processes import Lost, WorkerPool

SEQUENCE_LIMIT_S = 24 * 3600.0  # for a sequence in a worker
T = TypeVar("T")
R = TypeVar("R")


def sequence_results(
    function: Callable[[T], R],
    tasks: Sequence[T],
    names: Sequence[str],
    pool: WorkerPool | None,
    verb: str,
) -> Iterator[R]:
    """Yield function(task) of each task in order, each as early as it can be given.

    names: of the tasks' sequences; verb: what is done to them, as "checked", for messages. Without
    a pool, and for a single task, the work is done in this process. Raises InfrastructureError
    where the worker of a sequence dies three times, and what the function raises.
    """
    if pool is None or len(tasks) <= 1:
        yield from map(function, tasks)
        return
    ended: dict[int, R] = {}
    given = 0
    for indexed in pool.outcomes(function, dict(enumerate(tasks)), SEQUENCE_LIMIT_S):
        if indexed is None:
            continue
        index, outcome = indexed
        if isinstance(outcome, Lost):
            raise InfrastructureError(_lost_line(names[index], outcome, verb))
        ended[index] = outcome.value
        while given in ended:
            yield ended.pop(given)
            given += 1


def _lost_line(name: str, lost: Lost, verb: str) -> str:
    if lost.late:
        return f"{name}: not {verb} within {SEQUENCE_LIMIT_S / 3600:.0f} hours."
    return (
        f"{name}: its worker process died {lost.attempts} times (exit code {lost.exit_code}), "
        "likely for lack of memory: take fewer of them (--jobs)."
    )
