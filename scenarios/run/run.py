"""The verb `run`: plan episodes, play them, save the run, print the table."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.presets.names import DEFAULT_PRESET
from reports.page.page import write_page
from reports.run.rows import EpisodeRows
from reports.run.save import check_free
from reports.summary.budget import budget_of
from reports.summary.causes import blame_lines, budget_line
from reports.summary.tables import rich_table, summarise
from reports.summary.text import count
from scenarios.cache.report import origin_line
from scenarios.cache.settings import cache_settings
from scenarios.console.folder import default_folder
from scenarios.console.interrupts import Interrupted, Interrupts, interrupts
from scenarios.console.progress import progress_bar
from scenarios.execute.episodes import EPISODE_TIME_LIMIT_S, PlayResults, play_all
from scenarios.execute.executor import Executor
from scenarios.execute.isolated import allow_plug_ins_from_here, try_plug_ins
from scenarios.execute.local import local_executor, worker_count
from scenarios.play.from_dataset import open_with_sequences, renderer_of
from scenarios.play.job import Job
from scenarios.play.plan import PlanRequest, plan
from scenarios.run.corpus_verdict import outcomes_of, refuse_regressions, verdict_lines
from scenarios.run.save_run import save_run

MAX_TIME_LIMIT_S = 86_400.0


@dataclass(frozen=True)
class RunRequest:
    """Arguments of `run`; None: the default.

    plan: the episodes; jobs: worker processes; out: folder of the saved run; argv: the command
    line, for run.json; slim: save only what `compare` needs; time_limit_s: of one episode.
    """

    plan: PlanRequest = field(default_factory=PlanRequest)
    preset: str = DEFAULT_PRESET
    jobs: int | None = None
    out: Path | None = None
    argv: tuple[str, ...] = ()
    slim: bool = False
    time_limit_s: float = EPISODE_TIME_LIMIT_S


def run_suite(request: RunRequest) -> None:
    """Play, score, save and print.

    Raises BenchError; InfrastructureError where an episode gives no result, Interrupted after a
    signal: what is finished is saved before.
    """
    if not 0 < request.time_limit_s <= MAX_TIME_LIMIT_S:
        raise BenchError(
            f"--time-limit must be above 0 s, at most {MAX_TIME_LIMIT_S:g}, got "
            f"{request.time_limit_s:g}"
        )
    workers = worker_count(request.jobs)
    wanted = request.plan
    allow_plug_ins_from_here(wanted.detector, wanted.tracker)
    # Detections from files have no code to be tried.
    try_plug_ins(wanted.detector if wanted.detections is None else None, wanted.tracker)
    jobs = plan(wanted)
    names = wanted.targets if wanted.dataset is None else (wanted.dataset.absolute().name,)
    folder = request.out or default_folder(names)
    check_free(folder)
    with interrupts() as arrived:
        _play_and_save(request, jobs, workers, folder, arrived)


def _play_and_save(
    request: RunRequest, jobs: Sequence[Job], workers: int, folder: Path, arrived: Interrupts
) -> None:
    started = time.perf_counter()
    with local_executor(workers) as executor:
        played = _play_with_progress(jobs, executor, request.time_limit_s, arrived)
    # From here on signals are only counted: saving goes on to its end.
    if request.plan.dataset is not None:
        dataset = open_with_sequences(request.plan.dataset)
        played = replace(played, renderer=renderer_of(dataset))
    if not played.rows:
        raise Interrupted("interrupted before any episode was finished; nothing saved")
    wall_s = time.perf_counter() - started
    saved = save_run(
        request.plan,
        jobs,
        played,
        folder,
        preset=request.preset,
        argv=request.argv,
        slim=request.slim,
    )
    out = Console()
    out.print(rich_table(summarise(saved)))
    for line in blame_lines(saved.events):
        out.print(f"to blame for {line}", highlight=False)
    if (budget := budget_of(saved)) is not None:
        out.print(budget_line(budget), highlight=False)
    frames = sum(row.frame_count for row in played.rows)
    out.print(
        f"{count(len(played.rows), 'episode')}, {count(frames, 'stereo frame')} in {wall_s:.0f} s "
        f"({frames / wall_s:.1f} a second, {workers} workers)",
        highlight=False,
    )
    settings = cache_settings() if request.plan.use_cache else None
    if origin := origin_line(played.rows, settings):
        out.print(origin, highlight=False, soft_wrap=True)
    corpus = outcomes_of(request.plan.targets, jobs, played.rows)
    for line in verdict_lines(corpus):
        out.print(line, highlight=False, soft_wrap=True)
    if request.slim:
        out.print(f"slim run: {folder}", highlight=False, soft_wrap=True)
    else:
        page = write_page([saved], folder / "report.html")
        out.print(f"report: {page}", highlight=False, soft_wrap=True)
    if arrived.arrived:
        raise Interrupted(
            f"interrupted: {len(played.rows)} of {len(jobs)} episodes are in the saved run"
        )
    refuse_failures(played)
    refuse_regressions(corpus)


def refuse_failures(played: PlayResults) -> None:
    """Raise InfrastructureError where an episode gave no result; it names the first."""
    failed = [row for row in played.rows if row.failure]
    if failed:
        first = failed[0]
        raise InfrastructureError(
            f"{len(failed)} of {len(played.rows)} episodes gave no result, the first: "
            f"{first.scenario} seed {first.seed}: {first.failure}"
        )


def _play_with_progress(
    jobs: Sequence[Job], executor: Executor, time_limit_s: float, arrived: Interrupts
) -> PlayResults:
    with progress_bar(Console(stderr=True)) as progress:
        task = progress.add_task("starting", total=len(jobs))

        def on_done(row: EpisodeRows) -> None:
            label = f"{row.scenario} seed {row.seed}"
            progress.update(task, advance=1, description=label)

        with arrived.raising():
            return play_all(jobs, executor, on_done, time_limit_s)
