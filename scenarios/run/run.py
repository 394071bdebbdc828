"""The verb `run`: plan episodes, play them, save the run, print the table."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from pjpdaf.plugins.loading import allow_plug_ins_from_here
from pjpdaf.presets.registry import find_preset
from reports.run.rows import EpisodeRows
from reports.summary.text import count
from scenarios.console.folder import unfinished
from scenarios.console.interrupts import Interrupts, interrupts
from scenarios.console.progress import progress
from scenarios.execute.episodes import PlayResults, play_all
from scenarios.execute.executor import ClusterFault, Executor
from scenarios.execute.isolated import try_plug_ins
from scenarios.execute.local import check_time_limit
from scenarios.execute.place import Place, executor_at, place_of
from scenarios.execute.software import PlugIns
from scenarios.play.footage import plugged_motions
from scenarios.play.from_dataset import open_with_sequences, renderer_of
from scenarios.play.job import Job
from scenarios.play.plan import plan
from scenarios.run.finish import finish_run
from scenarios.run.request import REQUEST, RunRequest, read_request, resume_command
from scenarios.run.unfinished import UnfinishedRun, reserved, unfinished_run


def run_suite(request: RunRequest) -> None:
    """Play, score, save and print; go on with what is finished of the same run.

    Raises BenchError; InfrastructureError where an episode gives no result or the disk is full,
    Interrupted after a signal: what is finished is kept.
    """
    place = place_of(request.jobs, request.cluster)
    jobs = planned(request)
    with reserved(request, jobs, request.names) as run, interrupts() as arrived:
        started = time.perf_counter()
        played = play(request, run, place, arrived)
        wall_s = time.perf_counter() - started
        here = sum(row.frame_count for row in run.finished.values())
        now = max(sum(row.frame_count for row in played.rows) - here, 0)
        kept = f"; {len(run.finished)} were there" if run.finished else ""
        how = f"in {wall_s:.0f} s ({now / max(wall_s, 1e-9):.1f} a second, {place}){kept}"
        finish_run(request, run, played, how, arrived, cached_here=not place.scheduler)


def planned(request: RunRequest) -> list[Job]:
    """The episodes of a request, once its plug-ins are tried. Raises BenchError."""
    check_time_limit(request.time_limit_s)
    find_preset(request.preset)
    wanted = request.plan
    allow_plug_ins_from_here(wanted.detector, wanted.tracker)
    # Detections from files have no code to be tried.
    try_plug_ins(wanted.detector if wanted.detections is None else None, wanted.tracker)
    return plan(wanted)


def resume_run(
    folder: Path,
    detector: str | None,
    tracker: str | None,
    jobs: int | None,
    cluster: str | None,
    time_limit_s: float | None,
) -> None:
    """Go on with the unfinished run of a folder.

    detector, tracker: of the run, as the user names them; must be given for plug-ins. jobs,
    cluster, time_limit_s: None for the default and the run's own. Raises as `run_suite`.
    """
    folder = unfinished_run(folder)
    request = read_request(unfinished(folder) / REQUEST, detector, tracker)
    limit_s = request.time_limit_s if time_limit_s is None else time_limit_s
    run_suite(replace(request, out=folder, jobs=jobs, cluster=cluster, time_limit_s=limit_s))


def play(request: RunRequest, run: UnfinishedRun, place: Place, arrived: Interrupts) -> PlayResults:
    """Play what is not finished. Raises BenchError, ClusterFault with what is kept."""
    wanted = request.plan
    detector = wanted.detector if wanted.detections is None else None
    plug_ins = PlugIns.named(detector, wanted.tracker).with_motions(plugged_motions(run.jobs))
    with executor_at(place, plug_ins) as executor:
        try:
            played = _play_with_progress(run, executor, request.time_limit_s, arrived)
        except ClusterFault as fault:
            command = resume_command(run.shown, request)
            goes_on = (
                f"`{command}` goes on" if request.shard is None else "the same command goes on"
            )
            raise fault.reworded(
                f"{fault}; {run.kept} of {count(len(run.jobs), 'episode')} are kept"
                + (f"; {goes_on}, here or on a cluster" if run.kept else "")
            ) from fault
    return with_origin(request, played)


def with_origin(request: RunRequest, played: PlayResults) -> PlayResults:
    """The results with the renderer of the data set that they are of, if any."""
    if request.plan.dataset is None:
        return played
    dataset = open_with_sequences(request.plan.dataset)
    return replace(played, renderers=frozenset({renderer_of(dataset)}))


def _play_with_progress(
    run: UnfinishedRun, executor: Executor, time_limit_s: float, arrived: Interrupts
) -> PlayResults:
    """Play what is not finished; each episode is kept as it is finished."""
    frames = [job.frames for job in run.jobs]
    done = set(run.finished)
    with progress(running=executor.running_steps) as meter:

        def doing() -> str:
            return f"{len(done)}/{count(len(run.jobs), 'episode')}"

        def on_done(index: int, row: EpisodeRows) -> None:
            run.keep(run.jobs[index], row)
            done.add(index)
            meter.finish(frames[index], doing())

        meter.begin(doing(), sum(frames), finished=sum(frames[index] for index in done))
        with arrived.raising():
            return play_all(run.jobs, executor, on_done, time_limit_s, run.finished)
