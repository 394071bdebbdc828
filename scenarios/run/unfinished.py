"""The folder of an unfinished run, DIR.part beside DIR: what is finished of it survives anything.

It holds a journal of finished episodes (`scenarios.execute.journal`), locked while the run goes
on, and the request. The saved run is made in it, and becomes DIR by a rename.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError
from reports.run.rows import EpisodeRows
from reports.run.save import check_free, publish
from reports.run.stored_rows import rows_from_bytes, rows_to_bytes
from scenarios.console.folder import UNFINISHED, default_folder, unfinished
from scenarios.execute import journal
from scenarios.execute.journal import Journal
from scenarios.play.job import Job
from scenarios.run.identity import job_key, run_identity
from scenarios.run.request import REQUEST, RunRequest, Shard, stored_request, write_request
from sim.files import disk_faults

# Failures of the machine, not of the episode: such an episode is played again.
FAILED = "failed "  # before the key of such an episode, in the journal of a shard
OF_THE_MACHINE = ("worker died", "time limit")


@dataclass(frozen=True, eq=False)
class UnfinishedRun:
    """A reserved run: no other process can begin it or go on with it.

    folder: of the saved run, absolute; shown: as it was named; part: its own folder; finished:
    rows of the finished episodes, by the index of the job.
    """

    folder: Path
    shown: Path
    part: Path
    jobs: Sequence[Job]
    finished: Mapping[int, EpisodeRows]
    _journal: Journal

    @property
    def kept(self) -> int:
        """How many episodes are finished and on the disk."""
        return len(self._journal.finished)

    @property
    def staged(self) -> Path:
        """The folder in which the saved run is made."""
        return self.part / self.folder.name

    def keep(self, job: Job, rows: EpisodeRows) -> None:
        """Keep a finished episode; it is on the disk when this returns.

        Raises BenchError of the disk, InfrastructureError where it is full.
        """
        if rows.failure_kind not in OF_THE_MACHINE:
            with self.kept_after_faults():
                self._journal.append(job_key(job), rows_to_bytes(rows))

    def keep_failure(self, job: Job, rows: EpisodeRows) -> None:
        """Keep an episode that failed for the machine, for a merge; here it is played again."""
        with self.kept_after_faults():
            self._journal.append(FAILED + job_key(job), rows_to_bytes(rows))

    @contextmanager
    def kept_after_faults(self) -> Iterator[None]:
        """Add to a fault of the disk what the user wants to know most."""
        try:
            yield
        except BenchError as fault:
            raise fault.reworded(
                f"{fault} What is finished is kept in {self.part.name}; the same command goes on."
            ) from fault

    def publish(self) -> None:
        """Give the staged run its name. Raises BenchError of the disk."""
        with self.kept_after_faults(), disk_faults(self.folder, "the run"):
            check_free(self.folder, force=True)
            publish(self.staged, self.folder)

    def discard(self) -> None:
        """Remove what is unfinished: the run is complete."""
        _remove_all_but_journal(self.part, REQUEST)
        with suppress(OSError):
            (self.part / journal.FILE).unlink()  # last: while it is there, the same command goes on
            self.part.rmdir()


@contextmanager
def reserved(
    request: RunRequest, jobs: Sequence[Job], names: Sequence[str]
) -> Iterator[UnfinishedRun]:
    """Reserve the folder of a run, and read what was finished of it before.

    names: for a folder of its own, where the request has none. Raises BenchError where the folder
    is taken, another process makes this run, or another run was begun there.
    """
    shown = _new_folder(names) if request.out is None else request.out
    folder = Path(os.path.abspath(shown))  # noqa: PTH100 - keeps a link that is the folder's parent
    with disk_faults(folder, "the run"):
        begun = bool(folder.name) and (unfinished(folder) / journal.FILE).is_file()
    # What an interrupted run has saved is replaced when it is complete.
    check_free(folder, force=begun)
    part = unfinished(folder)
    identity = run_identity(jobs, request.preset)
    with Journal.open(part, identity) as opened:
        try:
            _remove_all_but_journal(part)
            with disk_faults(part, "the run"):
                write_request(part / REQUEST, request)
            yield UnfinishedRun(folder, shown, part, jobs, _finished_rows(opened, jobs), opened)
        finally:
            if not opened.finished:
                shutil.rmtree(part, ignore_errors=True)


@contextmanager
def reserved_shard(
    request: RunRequest, shard: Shard, folder: Path, jobs: Sequence[Job]
) -> Iterator[UnfinishedRun]:
    """Reserve the folder of a shard, and read what was finished of it before.

    jobs: of the whole run; those of the unfinished run are the shard's. Its journal has the
    identity of the whole run. Raises BenchError as `reserved`.
    """
    place = Path(os.path.abspath(folder))  # noqa: PTH100 - as in `reserved`
    own = [job for number, job in enumerate(jobs) if shard.owns(number)]
    if not own:
        raise BenchError(f"--shard {shard.index}/{shard.count}: the run has {len(jobs)} episodes")
    with Journal.open(place, run_identity(jobs, request.preset)) as opened:
        with disk_faults(place, "the shard"):
            before = place / REQUEST
            if before.is_file() and (had := stored_request(before).shard) != shard:
                raise BenchError(f"{folder}: holds {had}; give {shard} another folder")
            write_request(before, request)
        yield UnfinishedRun(place, folder, place, own, _finished_rows(opened, own), opened)


def _new_folder(names: Sequence[str]) -> Path:
    """A new name, which this process has for itself from now on."""
    while True:
        folder = default_folder(names)
        with disk_faults(folder, "the run"):
            folder.parent.mkdir(parents=True, exist_ok=True)
            with suppress(FileExistsError):
                unfinished(folder).mkdir()
                return folder


def _finished_rows(journal: Journal, jobs: Sequence[Job]) -> dict[int, EpisodeRows]:
    rows = {}
    for index, job in enumerate(jobs):
        data = journal.finished.get(job_key(job))
        if data is None:
            continue
        with suppress(ValueError):  # it is played again
            stored = rows_from_bytes(data)
            if (stored.scenario, stored.seed) == (job.name, job.seed):
                rows[index] = stored
    return rows


def _remove_all_but_journal(part: Path, *others: str) -> None:
    """Remove a half-saved run of a process that was killed; others: names of more to remove."""
    for path in part.iterdir():
        if path.name in {journal.FILE, REQUEST} - {*others}:
            continue
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def unfinished_run(path: Path) -> Path:
    """The folder that `run --resume PATH` is about: PATH, or that without its ending.

    Raises BenchError where nothing is unfinished there.
    """
    folder = path.with_name(path.name.removesuffix(UNFINISHED)) if path.name else path.absolute()
    if not folder.name:
        raise BenchError(f"{path}: no such unfinished run.")
    with disk_faults(folder, "the run"):
        if (unfinished(folder) / REQUEST).is_file():
            return folder
        if (folder / "run.json").is_file():
            raise BenchError(f"{folder}: is finished; there is nothing to go on with.")
    raise BenchError(f"{unfinished(folder)}: no such unfinished run; give the command once more.")
