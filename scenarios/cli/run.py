"""The verbs that save a run or make its page: run, report, score."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from pjpdaf.errors import BenchError
from pjpdaf.presets.names import DEFAULT_PRESET
from scenarios.cli.options import (
    ByTarget,
    Cluster,
    Detections,
    Jobs,
    Lag,
    PlugInName,
    PresetName,
    RunOut,
    Targets,
    refuse_both_detectors,
)


def run(
    targets: Targets = None,
    seeds: Annotated[
        int | None,
        typer.Option(help="Episodes of each scenario, seeds 0 to N-1 [the suite's own; 10]."),
    ] = None,
    preset: PresetName = DEFAULT_PRESET,
    detector: PlugInName = None,
    tracker: PlugInName = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a scenario parameter, or detector.NAME / tracker.NAME. Repeatable.",
        ),
    ] = None,
    jobs: Jobs = None,
    cluster: Cluster = None,
    out: RunOut = None,
    first_seed: Annotated[int, typer.Option(help="Where the seeds start.")] = 0,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Only this scenario of those named, as in the table."),
    ] = None,
    slim: Annotated[
        bool,
        typer.Option(
            "--slim", help="Keep only what `compare` needs: no frames, no films, no page."
        ),
    ] = False,
    films: Annotated[
        bool,
        typer.Option(
            "--films/--no-films",
            help="Keep small films, which the page plays: of all that went wrong, the worst first, "
            "then of the others, as far as 10 MB go; about 4.3 kB and 15 ms of a core a frame.",
        ),
    ] = True,
    time_limit: Annotated[
        float | None,
        typer.Option(help="How long one episode may take [s]; then it has failed [900]."),
    ] = None,
    from_: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="DIR",
            help="Instead: the sequences of a data set; nothing is rendered.",
        ),
    ] = None,
    detections: Detections = None,
    lag: Lag = 0,
    no_cache: Annotated[
        bool,
        typer.Option(
            "--no-cache", help="Render and detect all anew; `cache info` says what is kept."
        ),
    ] = False,
    resume: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Instead: go on with the unfinished run of this folder; so does its command.",
        ),
    ] = None,
    by_target: ByTarget = False,
    shard: Annotated[
        str | None,
        typer.Option(
            metavar="I/K",
            help="Play only the I-th of K parts, into --out; `merge` puts them together.",
        ),
    ] = None,
) -> None:
    """Play scenarios, score them, print the table, save the run and its report.

    Without a name: the suite smoke.
    """
    from scenarios.execute.episodes import EPISODE_TIME_LIMIT_S
    from scenarios.play.plan import PlanRequest
    from scenarios.run.request import RunRequest, parse_shard
    from scenarios.run.run import resume_run, run_suite

    if resume is not None:
        asked = (targets, seeds, settings, out, only, from_, detections, first_seed, slim)
        if any((*asked, not films, lag, no_cache, by_target, shard)) or preset != DEFAULT_PRESET:
            raise BenchError(
                "--resume goes on with what was asked for: beside it only --jobs, --cluster, "
                "--time-limit, and --tracker or --detector, which must be the same"
            )
        resume_run(resume, detector, tracker, jobs, cluster, time_limit)
        return
    refuse_both_detectors(detections, detector)
    part = None if shard is None else parse_shard(shard)
    request = RunRequest(
        PlanRequest(
            targets=tuple(targets or (() if from_ else ("smoke",))),
            seeds=seeds,
            first_seed=first_seed,
            only=tuple(only or ()),
            settings=tuple(settings or ()),
            detector=detector or (preset if detections is None else detections.name),
            tracker=tracker or preset,
            keep_pictures=not slim,
            keep_films=films and not slim,
            dataset=from_,
            detections=detections,
            lag=lag,
            use_cache=not no_cache,
        ),
        preset=preset,
        jobs=jobs,
        cluster=cluster,
        out=out,
        argv=tuple(sys.argv[1:]),
        slim=slim,
        time_limit_s=EPISODE_TIME_LIMIT_S if time_limit is None else time_limit,
        by_target=by_target,
        shard=part,
    )
    if part is not None:
        from scenarios.run.shard import play_shard

        play_shard(request, part)
        return
    run_suite(request)


def merge(
    shards: Annotated[
        list[Path], typer.Argument(metavar="DIR...", help="Folders of `run --shard`, all of them.")
    ],
    out: RunOut = None,
    detector: PlugInName = None,
    tracker: PlugInName = None,
    by_target: ByTarget = False,
) -> None:
    """Put the shards of a run together: the saved run that was not divided, byte for byte.

    A tracker or detector that is a plug-in must be named again, as it is code.
    """
    from scenarios.run.merge import MergeRequest, merge_shards

    argv = tuple(sys.argv[1:])
    merge_shards(MergeRequest(tuple(shards), out, detector, tracker, argv, by_target))


def report(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN", help="Folders of saved runs.")],
    out: Annotated[
        Path | None, typer.Option(help="Where the page goes [RUN/report.html, of one run].")
    ] = None,
    baseline: Annotated[
        Path | None,
        typer.Option(
            metavar="BASE",
            help="A saved run: the page begins with the gate's verdict against it.",
        ),
    ] = None,
    rerun: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.rrd",
            help="Instead of a page: a recording of one run for the viewer Rerun.",
        ),
    ] = None,
) -> None:
    """Make the report page of a saved run again, or one page of several side by side.

    Folders of `stress` search, map, estimate and compare go together on one stress page. With
    --rerun a new file with cameras, films, paths, errors and events instead, to be opened with
    `rerun FILE.rrd`; needs the extra `viz`.
    """
    if rerun is not None:
        if len(runs) != 1 or out is not None or baseline is not None:
            raise BenchError("--rerun takes one run, and goes without --out and --baseline.")
        from reports.rerun.run import write_rerun
        from reports.run.load import load
        from scenarios.console.interrupts import unwritten_if_interrupted

        with unwritten_if_interrupted(rerun):
            typer.echo(f"recording: {write_rerun(load(runs[0]), rerun)}")
        return
    from scenarios.run.report import remake_report

    typer.echo(f"report: {remake_report(runs, out, baseline)}")


def score(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="Folder of a data set.")],
    tracks: Annotated[
        Path,
        typer.Argument(metavar="TRACKS", help="CSV or Parquet, or a folder with one a sequence."),
    ],
    out: RunOut = None,
    frame: Annotated[
        str,
        typer.Option(help="Of positions: world, or left (the left camera's, as `track` writes)."),
    ] = "world",
    by_target: ByTarget = False,
) -> None:
    """Score anyone's tracks on a data set, save them as a run with its report.

    Columns: sequence, frame (from 0), target, x_m, y_m, z_m; status, sd_x_m, sd_y_m, sd_z_m,
    exchange_probability if known. Missing rows count as lost.
    """
    from scenarios.tracks.score import ScoreRequest, score_tracks

    score_tracks(ScoreRequest(dataset, tracks, out, frame, tuple(sys.argv[1:]), by_target))
