"""The end of a run: save its rows, make its page, print its table."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from pjpdaf.errors import InfrastructureError
from reports.page.page import write_page
from reports.run.load import SavedRun
from reports.summary.budget import budget_of
from reports.summary.causes import blame_lines, budget_line
from reports.summary.tables import summarise
from reports.summary.terminal import scenario_table, target_table
from reports.summary.text import count
from scenarios.cache.report import origin_line
from scenarios.cache.settings import cache_settings
from scenarios.console.interrupts import Interrupted, Interrupts
from scenarios.console.lines import print_line
from scenarios.console.progress import progress
from scenarios.console.tables import print_table
from scenarios.execute.episodes import PlayResults
from scenarios.play.footage import is_plugged_motion
from scenarios.run.corpus_verdict import (
    CaseOutcome,
    outcomes_of,
    refuse_regressions,
    verdict_lines,
)
from scenarios.run.request import RunRequest, resume_command
from scenarios.run.save_run import save_run
from scenarios.run.unfinished import UnfinishedRun


def finish_run(
    request: RunRequest,
    run: UnfinishedRun,
    played: PlayResults,
    how: str,
    arrived: Interrupts,
    *,
    cached_here: bool = True,
) -> None:
    """Save and print what was played. Signals are only counted: saving goes on to its end.

    how: it was played, for the terminal; cached_here: whether this machine's cache was used. Raises
    BenchError of the disk, InfrastructureError where an episode gives no result, Interrupted after
    a signal.
    """
    if not played.rows:
        raise Interrupted("interrupted before any episode was finished; nothing saved")
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
    _print_results(request, run, played, saved, corpus, how, cached_here)
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
    how: str,
    cached_here: bool,
) -> None:
    out = Console()
    table = target_table if request.by_target else scenario_table
    summary = summarise(saved)
    print_table(table(summary), out, wider=table(summary, wide=True))
    for line in blame_lines(saved.events):
        print_line(f"to blame for {line}", out)
    if (budget := budget_of(saved)) is not None:
        print_line(budget_line(budget), out)
    frames = sum(row.frame_count for row in played.rows)
    print_line(f"{count(len(played.rows), 'episode')}, {count(frames, 'stereo frame')} {how}", out)
    if len(played.renderers) > 1:
        listed = "; ".join(sorted(played.renderers))
        print_line(f"the renderer differs among the workers, and so do pixels: {listed}", out)
    cached = request.plan.use_cache and request.plan.dataset is None and cached_here
    settings = cache_settings() if cached else None
    plugged = sum(is_plugged_motion(job) for job in run.jobs)
    if origin := origin_line(played.rows, settings, plugged):
        print_line(origin, out)
    for line in verdict_lines(corpus):
        print_line(line, out)
    if request.slim:
        print_line(f"slim run: {run.shown}", out)
    else:
        print_line(f"report: {run.shown / 'report.html'}", out)


def refuse_failures(played: PlayResults) -> None:
    """Raise InfrastructureError where an episode gave no result; it names the first."""
    failed = [row for row in played.rows if row.failure]
    if failed:
        first = failed[0]
        raise InfrastructureError(
            f"{len(failed)} of {count(len(played.rows), 'episode')} gave no result, the first: "
            f"{first.scenario} seed {first.seed}: {first.failure}"
        )
