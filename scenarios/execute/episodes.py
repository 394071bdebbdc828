"""Many episodes, played by an executor."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from pjpdaf.errors import BenchError, InfrastructureError, PlugInFault
from pjpdaf.plugins.loading import describe_exception
from reports.run.films import FilmShelf
from reports.run.rows import EpisodeRows, rows_of
from reports.score.records import EpisodeFailure, FailureKind
from scenarios.execute.executor import Executor
from scenarios.play.footage import is_cached, remembered_renderer
from scenarios.play.job import Job, digest_of
from scenarios.play.play import play_complete
from sim.contact.contact import Unposable
from sim.processes import Answer, Lost

EPISODE_TIME_LIMIT_S = 900.0


@dataclass(frozen=True)
class PlayResults:
    """The results of a list of jobs, in their order; of an interrupted run the finished ones.

    renderers: descriptions of what drew their pictures, none where that is not known.
    """

    rows: tuple[EpisodeRows, ...]
    interrupted: bool
    renderers: frozenset[str]

    @property
    def renderer(self) -> str:
        """All renderers in one line, for run.json."""
        return "; ".join(sorted(self.renderers))


def _play_safely(job: Job) -> EpisodeRows | BenchError:
    """The rows of a played job: of a failed episode where it raises; a BenchError is returned."""
    try:
        return rows_of(play_complete(job))
    except Unposable as fault:
        return _failure(job, "unposable", f"cannot be posed: {fault}")
    except BenchError as fault:
        return fault
    except PlugInFault as fault:
        return _failure(job, "plug-in", str(fault))
    except (Exception, SystemExit, KeyboardInterrupt) as fault:
        # Of a plug-in, too: Ctrl-C does not reach a worker, and nothing of ours exits here.
        return _failure(job, "exception", describe_exception(fault))


def play_all(
    jobs: Sequence[Job],
    executor: Executor,
    on_done: Callable[[int, EpisodeRows], None] = lambda index, rows: None,
    time_limit_s: float = EPISODE_TIME_LIMIT_S,
    finished: Mapping[int, EpisodeRows] = MappingProxyType({}),
) -> PlayResults:
    """Play all jobs on an executor.

    on_done: called with each episode as it is finished, and the index of its job. finished: rows
    of episodes that are not played, by index; those that another renderer drew are.

    A worker that dies is replaced and its episode played again, three times at most; an episode
    over its time limit, or that raises, becomes a failed episode. Ctrl-C ends the run and keeps
    what is finished. Neither the rows nor their order depend on the executor.
    Raises BenchError (the first in the order of the jobs) where the user's input is at fault.
    OpenGL is needed only where a job is rendered.
    """
    results = dict(finished)
    interrupted = False
    renderers: frozenset[str] = frozenset()
    try:
        tasks = {index: job for index, job in enumerate(jobs) if index not in results}
        renderers = _renderers_here(executor, tasks.values())
        for index, row in finished.items():
            if renderers and row.renderer and row.renderer not in renderers:
                tasks[index] = jobs[index]
                del results[index]
        shelf = shelf_of(results, jobs)
        for indexed in executor.outcomes(_play_safely, tasks, time_limit_s):
            if indexed is None:
                continue
            index, outcome = indexed
            results[index] = _rows_of_outcome(outcome, jobs[index], time_limit_s)
            if results[index].film:
                _without_films(results, shelf.add(index, results[index]))
            on_done(index, results[index])
    except KeyboardInterrupt:
        interrupted = True
    played = results_of(results, interrupted)
    return played if played.renderers else replace(played, renderers=renderers)


def results_of(rows: Mapping[int, EpisodeRows], interrupted: bool = False) -> PlayResults:
    """Results by the index of the job."""
    ordered = tuple(rows[index] for index in sorted(rows))
    renderers = frozenset({row.renderer for row in ordered if row.renderer})
    return PlayResults(ordered, interrupted, renderers)


def _renderers_here(executor: Executor, jobs: Collection[Job]) -> frozenset[str]:
    """The renderers that draw these jobs, or drew them; none where nothing says.

    The executor's processes are asked where a job is to be rendered. Raises InfrastructureError
    without OpenGL, unless pictures of every job are in the cache.
    """
    drawn = [job for job in jobs if job.kept is None]
    if all(is_cached(job) for job in drawn):
        named = next(filter(None, map(remembered_renderer, drawn)), "")
        return frozenset({named}) - {""}
    try:
        return executor.renderers()
    except InfrastructureError:
        if all(is_cached(job, anyhow=True) for job in drawn):
            return frozenset()
        raise


def _rows_of_outcome(
    outcome: Answer[EpisodeRows | BenchError] | Lost, job: Job, time_limit_s: float
) -> EpisodeRows:
    """An episode's rows; a failed episode where there is no answer. Raises the user's faults."""
    if isinstance(outcome, Lost):
        if outcome.late:
            limit = f"{time_limit_s:.0f} s"
            return _failure(
                job, "time limit", f"not finished within {limit}; --time-limit gives it more"
            )
        return _failure(job, "worker died", outcome.death)
    if isinstance(outcome.value, BenchError):
        raise outcome.value
    return outcome.value


def shelf_of(results: dict[int, EpisodeRows], jobs: Sequence[Job]) -> FilmShelf:
    """The shelf with the films of finished episodes; those without a place are dropped there."""
    shelf = FilmShelf()
    for index, row in list(results.items()):
        if row.film:
            _without_films(results, shelf.add(index, row))
        elif jobs[index].keep_film and not row.failure:
            _without_films(results, shelf.close(row))
    return shelf


def _without_films(results: dict[int, EpisodeRows], dropped: Sequence[int]) -> None:
    """Forget films that will not be saved: all of them together would not fit into memory."""
    for index in dropped:
        results[index] = replace(results[index], film=())


def _failure(job: Job, kind: FailureKind, reason: str) -> EpisodeRows:
    return rows_of(
        EpisodeFailure(job.name, job.seed, reason, job.scenario.group, digest_of(job), kind)
    )
