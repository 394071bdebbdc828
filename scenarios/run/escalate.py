"""Escalation: an inconclusive comparison is decided with more seeds, in sizes fixed beforehand.

The reserve seeds start where `--seeds` never comes, so nothing was ever tuned on them. Every look
at the grown data has its share of the false alarms allowed in all (`reports.gate.gate.compare`).
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError
from pjpdaf.plugins.loading import allow_plug_ins_from_here
from pjpdaf.presets.registry import PRESETS
from reports.gate.gate import compare
from reports.gate.pairing import joined, measured
from reports.gate.replay import system_options
from reports.gate.verdict import Verdict
from reports.run.load import SavedRun
from reports.run.rows import EpisodeRows
from reports.run.tables import tables_of
from scenarios.execute.episodes import PlayResults, play_all
from scenarios.execute.executor import Executor
from scenarios.play.job import Job, digest_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.run.save_run import save_run

FIRST_RESERVE_SEED = 1_000_000
ROUNDS = (1, 2, 4)  # times the seeds that the runs have, one round after the other
LOOKS = 1 + len(ROUNDS)
PROOFS = 3  # episodes that are played again to see that this code made the runs

OnDone = Callable[[int, EpisodeRows], None]
OnRound = Callable[[int, Sequence[Job]], OnDone]  # number of the round, jobs -> called for each


class CannotEscalate(BenchError):
    """The runs cannot be continued here; the line says how to do it by hand. Inconclusive."""

    exit_code = 3


def escalate(
    base: SavedRun,
    new: SavedRun,
    margins: Mapping[str, float],
    executor: Executor,
    folder: Path,
    on_round: OnRound,
    here: Mapping[str, Any],
    plug_ins: Collection[str] = (),
) -> Verdict:
    """Play the reserve, round by round, until the verdict is clear or the last one is played.

    The played rounds are saved below `folder`. here: the provenance of this code; plug_ins: names
    that the user allows to be imported. Raises CannotEscalate where one of the runs was not made by
    this very code, KeyboardInterrupt.
    """
    reason = refusal(base, new, here)
    if reason:
        raise CannotEscalate(manual_command(new, reason))
    plans = planned_jobs(base, plug_ins), planned_jobs(new, plug_ins)
    _check_reproducible((base, new), plans, executor)
    verdict = compare(base, new, margins, looks=LOOKS)
    for number in range(len(ROUNDS)):
        if verdict.verdict != "inconclusive":
            break
        base, new = play_round((base, new), plans, number, executor, folder, on_round)
        verdict = compare(base, new, margins, looks=LOOKS)
    return verdict


def refusal(base: SavedRun, new: SavedRun, here: Mapping[str, Any]) -> str:
    """Why runs cannot be continued by the code that `here` is the provenance of; "" where they can.

    Installed packages have no commit; there the version stands for the code.
    """
    for run in (base, new):
        made = run.meta["provenance"]
        if not run.meta.get("request"):
            return f"{run.folder} does not say how it was started"
        if run.meta["request"].get("dataset"):
            return f"{run.folder} played a data set, which has no further seeds"
        if made["commit"] != here["commit"]:
            return f"{run.folder} was made by commit {_short(made)}, this is {_short(here)}"
        if made["dirty"] or here["dirty"]:
            where = str(run.folder) if made["dirty"] else "this checkout"
            return f"{where} has changes that are not committed"
        for name, version in made["versions"].items():
            if here["versions"].get(name) != version:
                return f"{run.folder} was made with {name} {version}"
    return ""


def _short(made: Mapping[str, Any]) -> str:
    return str(made["commit"] or "unknown")[:12]


def manual_command(new: SavedRun, reason: str) -> str:
    """The line, with the command to give by hand, for runs that cannot be continued here."""
    request = new.meta.get("request")
    if request and request.get("dataset"):
        return (
            f"inconclusive, and there is no reserve: {reason}; make a data set of more --seeds, "
            "play it with each of the two versions and compare these runs"
        )
    seeds = sum(ROUNDS) * max(len(scenario["seeds"]) for scenario in new.meta["scenarios"])
    words = [*request["targets"], *system_options(new.meta)] if request else ["..."]
    return (
        f"inconclusive, and the reserve cannot be played here: {reason}; play it with each of the "
        f"two versions and compare these runs: pjpdaf-bench run {shlex.join(words)} "
        f"--first-seed {FIRST_RESERVE_SEED} --seeds {seeds} --slim --out DIR"
    )


def request_of(run: SavedRun) -> PlanRequest:
    """The plan that a run was made from."""
    request, meta = run.meta["request"], run.meta
    return PlanRequest(
        targets=tuple(request["targets"]),
        seeds=request["seeds"],
        first_seed=int(request["first_seed"]),
        only=tuple(request["only"]),
        settings=tuple(request["settings"]),
        detector=str(meta["detector"]),
        tracker=str(meta["tracker"]),
        lag=int(meta.get("lag_frames", 0)),
    )


def planned_jobs(run: SavedRun, plug_ins: Collection[str] = ()) -> list[Job]:
    """Plan the jobs of a run again.

    plug_ins: detectors and trackers that may be imported; a run of unknown origin can name any
    module. Raises CannotEscalate where they differ from the run's, or others are needed.
    """
    request = request_of(run)
    for kind, name in (("detector", request.detector), ("tracker", request.tracker)):
        if name not in PRESETS and name not in plug_ins:
            reason = (
                f"the {kind} {name!r} of {run.folder} is imported only where the command line "
                f"allows it: --plug-in {shlex.quote(name)}"
            )
            raise CannotEscalate(manual_command(run, reason))
    allow_plug_ins_from_here(request.detector, request.tracker)
    try:
        jobs = plan(request)
    except BenchError as fault:
        raise CannotEscalate(manual_command(run, str(fault))) from fault
    now = {(job.name, job.seed): digest_of(job) for job in jobs}
    if now != run.digests:
        raise CannotEscalate(manual_command(run, f"the scenarios of {run.folder} have changed"))
    return jobs


def _check_reproducible(
    runs: Sequence[SavedRun], plans: Sequence[Sequence[Job]], executor: Executor
) -> None:
    """Play a few episodes of each run again: the same code gives the same, bit for bit.

    Plug-ins have no version of ours: this check shows where a plug-in has changed.
    """
    chosen = [[jobs[k * len(jobs) // PROOFS] for k in range(PROOFS)] for jobs in plans]
    chosen = [list({(job.name, job.seed): job for job in jobs}.values()) for jobs in chosen]
    played = _finished(play_all([job for jobs in chosen for job in jobs], executor))
    for run, jobs in zip(runs, chosen, strict=True):
        mine, played = played[: len(jobs)], played[len(jobs) :]
        for job, row in zip(jobs, mine, strict=True):
            if not same_episode(run, row):
                reason = f"{job.name} seed {job.seed} of {run.folder} comes out differently now"
                raise CannotEscalate(manual_command(run, reason))


def same_episode(run: SavedRun, row: EpisodeRows) -> bool:
    """Whether an episode, played again, gives the counts and sums that the run has of it."""
    now = measured(tables_of([row])["episodes"].to_pandas(), run.version)
    mine = (run.episodes["scenario"] == row.scenario) & (run.episodes["seed"] == row.seed)
    return bool(now.equals(measured(run.episodes[mine], run.version).reset_index(drop=True)))


def reserve_jobs(jobs: Sequence[Job], number: int) -> list[Job]:
    """The jobs of a round: for each scenario ROUNDS[number] times as many new seeds as it has."""
    reserve = []
    for name in dict.fromkeys(job.name for job in jobs):
        mine = [job for job in jobs if job.name == name]
        first = FIRST_RESERVE_SEED + sum(ROUNDS[:number]) * len(mine)
        reserve += [
            replace(mine[0], seed=first + k, keep_pictures=False)
            for k in range(ROUNDS[number] * len(mine))
        ]
    return reserve


def play_round(
    runs: Sequence[SavedRun],
    plans: Sequence[Sequence[Job]],
    number: int,
    executor: Executor,
    folder: Path,
    on_round: OnRound,
) -> tuple[SavedRun, SavedRun]:
    """Both runs with the episodes of the next round, which are saved as FOLDER/base-1, new-1.

    Raises KeyboardInterrupt where the round is not played to its end.
    """
    jobs = [reserve_jobs(planned, number) for planned in plans]
    every = [job for reserve in jobs for job in reserve]
    rows = _finished(play_all(every, executor, on_round(number, every)))
    grown = []
    for name, run, mine in zip(("base", "new"), runs, jobs, strict=True):
        part, rows = rows[: len(mine)], rows[len(mine) :]
        played = PlayResults(tuple(part), False, frozenset({run.meta["provenance"]["renderer"]}))
        out = folder / f"{name}-{number + 1}"
        saved = save_run(
            request_of(run),
            mine,
            played,
            out,
            preset=str(run.meta["preset"]),
            slim=True,
            force=True,
        )
        grown.append(joined([run, saved]))
    return grown[0], grown[1]


def _finished(played: PlayResults) -> list[EpisodeRows]:
    if played.interrupted:
        raise KeyboardInterrupt
    return list(played.rows)
