"""The verb `run`: plan episodes, play them, save the run, print the table."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.presets.registry import find_preset
from reports.page.page import write_page
from reports.run.load import SavedRun
from reports.run.rows import EpisodeRows
from reports.summary.budget import budget_of
from reports.summary.causes import blame_lines, budget_line
from reports.summary.tables import summarise
from reports.summary.terminal import scenario_table, target_table
from reports.summary.text import count
from scenarios.cache.report import origin_line
from scenarios.cache.settings import cache_settings
from scenarios.console.folder import unfinished
from scenarios.console.interrupts import Interrupted, Interrupts, interrupts
from scenarios.console.progress import progress
from scenarios.console.tables import print_table
from scenarios.execute.episodes import PlayResults, play_all
from scenarios.execute.executor import ClusterFault, Executor
from scenarios.execute.isolated import allow_plug_ins_from_here, try_plug_ins
from scenarios.execute.place import Place, executor_at, place_of
from scenarios.execute.software import PlugIns
from scenarios.play.from_dataset import open_with_sequences, renderer_of
from scenarios.play.plan import plan
from scenarios.run.corpus_verdict import (
    CaseOutcome,
    outcomes_of,
    refuse_regressions,
    verdict_lines,
)
from scenarios.run.request import REQUEST, RunRequest, read_request, resume_command
from scenarios.run.save_run import save_run
from scenarios.run.unfinished import UnfinishedRun, reserved, unfinished_run

MAX_TIME_LIMIT_S = 86_400.0


def run_suite(request: RunRequest) -> None:
    """Play, score, save and print; go on with what is finished of the same run.

    Raises BenchError; InfrastructureError where an episode gives no result or the disk is full,
    Interrupted after a signal: what is finished is kept.
    """
    if not 0 < request.time_limit_s <= MAX_TIME_LIMIT_S:
        raise BenchError(
            f"--time-limit must be above 0 s, at most {MAX_TIME_LIMIT_S:g}, got "
            f"{request.time_limit_s:g}"
        )
    find_preset(request.preset)
    place = place_of(request.jobs, request.cluster)
    wanted = request.plan
    allow_plug_ins_from_here(wanted.detector, wanted.tracker)
    # Detections from files have no code to be tried.
    try_plug_ins(wanted.detector if wanted.detections is None else None, wanted.tracker)
    jobs = plan(wanted)
    names = wanted.targets if wanted.dataset is None else (wanted.dataset.absolute().name,)
    with reserved(request, jobs, names) as run, interrupts() as arrived:
        _play_and_save(request, run, place, arrived)


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


def _play_and_save(
    request: RunRequest, run: UnfinishedRun, place: Place, arrived: Interrupts
) -> None:
    started = time.perf_counter()
    wanted = request.plan
    detector = wanted.detector if wanted.detections is None else None
    plug_ins = PlugIns.named(detector, wanted.tracker)
    with executor_at(place, plug_ins) as executor:
        try:
            played = _play_with_progress(run, executor, request.time_limit_s, arrived)
        except ClusterFault as fault:
            goes_on = f"`{resume_command(run.shown, request)}` goes on, here or on a cluster"
            raise fault.reworded(
                f"{fault}; {run.kept} of {count(len(run.jobs), 'episode')} are kept"
                + (f"; {goes_on}" if run.kept else "")
            ) from fault
    # From here on signals are only counted: saving goes on to its end.
    if request.plan.dataset is not None:
        dataset = open_with_sequences(request.plan.dataset)
        played = replace(played, renderers=frozenset({renderer_of(dataset)}))
    if not played.rows:
        raise Interrupted("interrupted before any episode was finished; nothing saved")
    wall_s = time.perf_counter() - started
    with run.kept_after_faults(), progress() as meter:
        meter.begin("saving the run", None)
        saved = save_run(
            request.plan,
            run.jobs,
            played,
            run.staged,
            preset=request.preset,
            argv=request.argv,
            slim=request.slim,
        )
        if not request.slim:
            meter.begin("writing the page", None)
            write_page([saved], run.staged / "report.html")
    run.publish()
    corpus = outcomes_of(request.plan.targets, run.jobs, played.rows)
    _print_results(request, run, played, saved, corpus, wall_s, place)
    if saved.meta["complete"]:
        run.discard()
    if arrived.arrived:
        remedy = f"; `{resume_command(run.shown, request)}` goes on" if played.interrupted else ""
        raise Interrupted(
            f"interrupted: {len(played.rows)} of {count(len(run.jobs), 'episode')} are in the "
            f"saved run{remedy}"
        )
    refuse_failures(played)
    refuse_regressions(corpus)


def _print_results(
    request: RunRequest,
    run: UnfinishedRun,
    played: PlayResults,
    saved: SavedRun,
    corpus: Sequence[CaseOutcome],
    wall_s: float,
    place: Place,
) -> None:
    out = Console()
    table = target_table if request.by_target else scenario_table
    print_table(table(summarise(saved)), out)
    for line in blame_lines(saved.events):
        out.print(f"to blame for {line}", highlight=False)
    if (budget := budget_of(saved)) is not None:
        out.print(budget_line(budget), highlight=False)
    frames = sum(row.frame_count for row in played.rows)
    now = frames - sum(row.frame_count for row in run.finished.values())
    kept = f"; {len(run.finished)} were there" if run.finished else ""
    out.print(
        f"{count(len(played.rows), 'episode')}, {count(frames, 'stereo frame')} in {wall_s:.0f} s "
        f"({max(now, 0) / wall_s:.1f} a second, {place}){kept}",
        highlight=False,
    )
    if len(played.renderers) > 1:
        listed = "; ".join(sorted(played.renderers))
        out.print(
            f"the renderer differs among the workers, and so do pixels: {listed}",
            highlight=False,
            soft_wrap=True,
        )
    # What workers of a cluster keep lies with them.
    cached = request.plan.use_cache and request.plan.dataset is None and not place.scheduler
    settings = cache_settings() if cached else None
    if origin := origin_line(played.rows, settings):
        out.print(origin, highlight=False, soft_wrap=True)
    for line in verdict_lines(corpus):
        out.print(line, highlight=False, soft_wrap=True)
    if request.slim:
        out.print(f"slim run: {run.shown}", highlight=False, soft_wrap=True)
    else:
        out.print(f"report: {run.shown / 'report.html'}", highlight=False, soft_wrap=True)


def refuse_failures(played: PlayResults) -> None:
    """Raise InfrastructureError where an episode gave no result; it names the first."""
    failed = [row for row in played.rows if row.failure]
    if failed:
        first = failed[0]
        raise InfrastructureError(
            f"{len(failed)} of {count(len(played.rows), 'episode')} gave no result, the first: "
            f"{first.scenario} seed {first.seed}: {first.failure}"
        )


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
