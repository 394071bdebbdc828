"""The verb `run --shard I/K`: play a part of a run, which `merge` puts together with the others."""

from __future__ import annotations

import time

from pjpdaf.errors import BenchError
from reports.summary.text import count
from scenarios.console.interrupts import Interrupted, interrupts
from scenarios.console.lines import print_line
from scenarios.execute.place import place_of
from scenarios.run.finish import refuse_failures
from scenarios.run.request import RunRequest, Shard
from scenarios.run.run import planned, play
from scenarios.run.unfinished import OF_THE_MACHINE, reserved_shard


def play_shard(request: RunRequest, shard: Shard) -> None:
    """Play a shard into its folder, and print its size; go on with what is finished of it.

    Raises BenchError; InfrastructureError where an episode gives no result, Interrupted after a
    signal: what is finished is kept.
    """
    if request.out is None:
        raise BenchError("--shard needs --out DIR: the folder of the shard, for `merge`")
    place = place_of(request.jobs, request.cluster)
    jobs = planned(request)
    with reserved_shard(request, shard, request.out, jobs) as run, interrupts() as arrived:
        started = time.perf_counter()
        played = play(request, run, place, arrived)
        if played.interrupted or arrived.arrived:
            raise Interrupted(
                f"interrupted: {run.kept} of {len(run.jobs)} episodes of {shard} are kept in "
                f"{request.out}; the same command goes on"
            )
        for job, rows in zip(run.jobs, played.rows, strict=True):
            if rows.failure_kind in OF_THE_MACHINE:
                run.keep_failure(job, rows)
    frames = sum(rows.frame_count for rows in played.rows)
    kept = f"; {len(run.finished)} were there" if run.finished else ""
    print_line(
        f"{shard}: {len(run.jobs)} of {count(len(jobs), 'episode')}, "
        f"{count(frames, 'stereo frame')} in {time.perf_counter() - started:.0f} s ({place}){kept}"
    )
    print_line(f"{request.out}: for `pjpdaf-bench merge`")
    refuse_failures(played)
