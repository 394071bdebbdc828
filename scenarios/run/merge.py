"""The verb `merge`: the shards of a run become the run that was not divided, byte for byte."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path

from pjpdaf.errors import BenchError, NotComparable
from reports.run.rows import EpisodeRows
from reports.run.stored_rows import rows_from_bytes, rows_to_bytes
from reports.summary.text import count
from scenarios.console.interrupts import interrupts
from scenarios.execute.episodes import results_of, shelf_of
from scenarios.execute.journal import Journal
from scenarios.play.job import Job
from scenarios.run.finish import finish_run
from scenarios.run.identity import job_key, run_identity
from scenarios.run.request import REQUEST, RunRequest, Shard, read_request, resume_command
from scenarios.run.run import planned, with_origin
from scenarios.run.unfinished import FAILED, OF_THE_MACHINE, reserved


@dataclass(frozen=True)
class MergeRequest:
    """The options of `merge`.

    folders: of shards; out: of the saved run, None for a name of its own; detector, tracker: those
    of the shards, where they are plug-ins; argv: the command line, for run.json.
    """

    folders: tuple[Path, ...]
    out: Path | None = None
    detector: str | None = None
    tracker: str | None = None
    argv: tuple[str, ...] = ()
    by_target: bool = False


@dataclass(frozen=True)
class _Part:
    """The folder of a shard, and what it says of itself."""

    folder: Path
    shard: Shard
    request: RunRequest


def merge_shards(wanted: MergeRequest) -> None:
    """Save the whole run and print its table, as `run` does.

    Raises BenchError where a shard is missing or unfinished, NotComparable where shards are of
    different runs, code or versions, or do not agree on an episode; InfrastructureError where an
    episode has no result.
    """
    parts = [_part(folder, wanted) for folder in wanted.folders]
    for part in parts[1:]:
        _check_same_run(parts[0], part)
    request = replace(
        parts[0].request, out=wanted.out, argv=wanted.argv, by_target=wanted.by_target, shard=None
    )
    jobs = planned(request)
    identity = run_identity(jobs, request.preset)
    rows: dict[int, EpisodeRows] = {}
    origin: dict[int, _Part] = {}
    for part in parts:
        for number, found in _rows_of(part, jobs, identity).items():
            if number in rows and not _replaces(found, rows[number]):
                _check_equal(jobs[number], rows[number], found, origin[number], part)
            else:
                rows[number], origin[number] = found, part
    _check_whole(parts, jobs, rows)
    shelf_of(rows, jobs)
    played = with_origin(request, results_of(rows))
    with reserved(request, jobs, request.names) as run, interrupts() as arrived:
        finish_run(request, run, played, f"of {count(len(parts), 'shard')}", arrived)


def _part(folder: Path, wanted: MergeRequest) -> _Part:
    if not (folder / REQUEST).is_file():
        raise BenchError(f"{folder}: is no shard of a run: there is no {REQUEST} in it")
    request = read_request(folder / REQUEST, wanted.detector, wanted.tracker)
    if request.shard is None:
        raise BenchError(
            f"{folder}: is no shard, but an unfinished run; `{resume_command(folder, request)}` "
            "goes on with it"
        )
    return _Part(folder, request.shard, request)


def _check_same_run(first: _Part, other: _Part) -> None:
    """Raise NotComparable where two shards are not of the same run."""
    for name in ("plan", "preset", "slim"):
        ours, theirs = getattr(first.request, name), getattr(other.request, name)
        if name == "plan" and ours != theirs:
            changed = [
                f.name for f in fields(ours) if getattr(ours, f.name) != getattr(theirs, f.name)
            ]
            name = changed[0]
            ours, theirs = getattr(ours, name), getattr(theirs, name)
        if ours != theirs:
            raise NotComparable(
                f"{other.folder}: is a shard of another run than {first.folder}: {name} "
                f"{_shown(theirs)}, there {_shown(ours)}"
            )
    if first.shard.count != other.shard.count:
        raise NotComparable(
            f"{other.folder}: is {other.shard}, {first.folder} is {first.shard}: the run was "
            "divided in two ways"
        )


def _shown(value: object) -> str:
    return " ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _rows_of(part: _Part, jobs: Sequence[Job], identity: str) -> dict[int, EpisodeRows]:
    """The rows that a shard has, by the number of the episode in the run."""
    rows = {}
    with Journal.reading(part.folder) as (owner, finished):
        if owner != identity:
            raise NotComparable(
                f"{part.folder}: was played with other code, plug-ins or versions of libraries "
                "than are here; merge with those, or play it again"
            )
        for number, job in enumerate(jobs):
            key = job_key(job) if part.shard.owns(number) else ""
            for name in (key, FAILED + key):
                with suppress(KeyError, ValueError):  # not there, or not readable: not finished
                    found = rows_from_bytes(finished[name])
                    if (found.scenario, found.seed) == (job.name, job.seed):
                        rows[number] = found
                        break
    return rows


def _replaces(found: EpisodeRows, before: EpisodeRows) -> bool:
    """Whether an episode was played to its end, and failed for the machine before."""
    return before.failure_kind in OF_THE_MACHINE and found.failure_kind not in OF_THE_MACHINE


def _check_equal(
    job: Job, ours: EpisodeRows, theirs: EpisodeRows, first: _Part, other: _Part
) -> None:
    """Raise NotComparable where two shards do not agree on an episode."""
    of_machine = {ours.failure_kind, theirs.failure_kind} & {*OF_THE_MACHINE}
    if not of_machine and _lasting(ours) != _lasting(theirs):
        drawn = f" (drawn by {ours.renderer} and {theirs.renderer})"
        raise NotComparable(
            f"{job.name} seed {job.seed}: {first.folder} and {other.folder} do not agree"
            + (drawn if ours.renderer != theirs.renderer else "")
            + "; leave out one of them"
        )


def _lasting(rows: EpisodeRows) -> bytes:
    """An episode as bytes, without what differs each time that it is played."""
    lasting = replace(rows, stage_s={}, film=(), replayed=False, detections_kept=False)
    return rows_to_bytes(lasting)


def _check_whole(parts: Sequence[_Part], jobs: Sequence[Job], rows: Mapping[int, object]) -> None:
    """Raise BenchError where a shard is missing, or is not finished."""
    missing = [number for number in range(len(jobs)) if number not in rows]
    if not missing:
        return
    lost = count(len(missing), "episode")
    split = parts[0].shard.count
    given = {part.shard.index: part.folder for part in parts}
    absent = sorted({number % split + 1 for number in missing} - {*given})
    if absent:
        named = ", ".join(f"{index}/{split}" for index in absent[:10])
        more = f" and {len(absent) - 10} more" if len(absent) > 10 else ""
        are = "shard {} is" if len(absent) == 1 else "shards {} are"
        raise BenchError(f"{are.format(named + more)} missing, with {lost}; name all shards")
    first = missing[0]
    raise BenchError(
        f"{given[first % split + 1]}: is not finished: {lost} missing, the first "
        f"{jobs[first].name} seed {jobs[first].seed}; give its command once more"
    )
