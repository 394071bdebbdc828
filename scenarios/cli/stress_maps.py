"""The verbs of `stress` that play many draws: map, estimate, compare."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from pjpdaf.presets.names import DEFAULT_PRESET
from scenarios.cli.options import Cluster, Jobs, PlugInName, PresetName
from scenarios.cli.stress import (
    Also,
    FidelityName,
    Ranges,
    Seed,
    Settings,
    StressOut,
    TimeLimit,
    campaign_of,
)


def map_failures(
    ctx: typer.Context,
    x: Annotated[str, typer.Option(metavar="NAME", help="Parameter along x; fps is one too.")],
    y: Annotated[
        str | None, typer.Option(metavar="NAME", help="Along y; without it the map is a curve.")
    ] = None,
    find: Annotated[
        str, typer.Option(help="Whose contour is refined: swap, head (with a hand), lost.")
    ] = "swap",
    cells: Annotated[int, typer.Option(help="Along each axis, before any is split.")] = 8,
    seeds: Annotated[int, typer.Option(help="Trials of each cell.")] = 8,
    refine: Annotated[int, typer.Option(help="How often cells on the contour are split.")] = 1,
    level: Annotated[float, typer.Option(help="The share of failures of the contour.")] = 0.5,
    others: Annotated[
        str, typer.Option(help="The other parameters: drawn (nominally, per seed) or medians.")
    ] = "drawn",
    episodes: Annotated[
        int, typer.Option(help="Trials of each map that the page plays, one a cell.")
    ] = 60,
    preset: PresetName = DEFAULT_PRESET,
    detector: PlugInName = None,
    tracker: PlugInName = None,
    settings: Settings = None,
    also: Also = None,
    ranges: Ranges = None,
    fidelity: FidelityName = None,
    seed: Seed = 0,
    jobs: Jobs = None,
    cluster: Cluster = None,
    out: StressOut = None,
    time_limit: TimeLimit = 900.0,
) -> None:
    """Map the failures over two parameters, or draw the curve over one.

    Writes stress.html, where a click on a cell plays a trial of it. The same command goes on where
    it was interrupted.
    """
    from scenarios.stress.map.explore import MapPlan, others_named
    from scenarios.stress.map_verb import MapRequest, map_verb
    from scenarios.stress.search_verb import goal_of

    map_verb(
        MapRequest(
            campaign_of(
                "map",
                ctx,
                detector or preset,
                tracker or preset,
                settings=settings,
                also=also,
                ranges=ranges,
                fidelity=fidelity,
                seed=seed,
                jobs=jobs,
                cluster=cluster,
                out=out,
                time_limit_s=time_limit,
            ),
            MapPlan(x, y, cells, seeds, refine, goal_of(find), level, others_named(others), seed),
            episodes,
            tuple(sys.argv[1:]),
        )
    )


def estimate(
    ctx: typer.Context,
    find: Annotated[
        str, typer.Option(metavar="A,B", help="Of swap, head (a swap with it), lost; or all.")
    ] = "swap,lost",
    runs: Annotated[int, typer.Option(help="Of each family and event, adaptation included.")] = 500,
    full: Annotated[
        int, typer.Option(help="Rendered runs that correct each figure of fast ones; 0: none.")
    ] = 20,
    method: Annotated[
        str, typer.Option(help="auto, plain (counting), importance (weighted draws).")
    ] = "auto",
    preset: PresetName = DEFAULT_PRESET,
    detector: PlugInName = None,
    tracker: PlugInName = None,
    settings: Settings = None,
    also: Also = None,
    fidelity: FidelityName = None,
    seed: Seed = 0,
    jobs: Jobs = None,
    cluster: Cluster = None,
    out: StressOut = None,
    time_limit: TimeLimit = 900.0,
) -> None:
    """Estimate how likely a failure is under the nominal distribution, with its 95 % interval.

    Exit code 3 where an estimate is inconclusive. Writes stress.html. The same command goes on
    where it was interrupted.
    """
    from scenarios.stress.estimate_verb import EstimateRequest, estimate_verb

    raise typer.Exit(
        estimate_verb(
            EstimateRequest(
                campaign_of(
                    "estimate",
                    ctx,
                    detector or preset,
                    tracker or preset,
                    settings=settings,
                    also=also,
                    fidelity=fidelity,
                    seed=seed,
                    jobs=jobs,
                    cluster=cluster,
                    out=out,
                    time_limit_s=time_limit,
                ),
                find,
                runs,
                full,
                method,
                tuple(sys.argv[1:]),
            )
        )
    )


def compare(
    ctx: typer.Context,
    a: Annotated[str, typer.Argument(metavar="A", help="Preset, entry point or module:factory.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Likewise; a preset has its detector.")],
    find: Annotated[
        str, typer.Option(metavar="C,D", help="Of swap, head (a swap with it), lost; or all.")
    ] = "swap,lost",
    runs: Annotated[int, typer.Option(help="Common draws of each family.")] = 200,
    x: Annotated[
        str | None, typer.Option(metavar="NAME", help="With --y: a map of the difference.")
    ] = None,
    y: Annotated[str | None, typer.Option(metavar="NAME", help="Along y of that map.")] = None,
    cells: Annotated[int, typer.Option(help="Of the map, along each axis.")] = 6,
    seeds: Annotated[int, typer.Option(help="Trials of each of its cells.")] = 6,
    detector: PlugInName = None,
    settings: Settings = None,
    also: Also = None,
    ranges: Ranges = None,
    fidelity: FidelityName = None,
    seed: Seed = 0,
    jobs: Jobs = None,
    cluster: Cluster = None,
    out: StressOut = None,
    time_limit: TimeLimit = 900.0,
) -> None:
    """Compare two trackers on common draws: P(B) - P(A) with its interval, and where they differ.

    Writes stress.html. The same command goes on where it was interrupted.
    """
    from pjpdaf.presets.registry import PRESETS
    from scenarios.stress.compare_verb import CompareRequest, compare_verb, difference_plan

    compare_verb(
        CompareRequest(
            campaign_of(
                "compare",
                ctx,
                detector or (a if a in PRESETS else DEFAULT_PRESET),
                a,
                settings=settings,
                also=also,
                ranges=ranges,
                fidelity=fidelity,
                against=b,
                seed=seed,
                jobs=jobs,
                cluster=cluster,
                out=out,
                time_limit_s=time_limit,
            ),
            find,
            runs,
            difference_plan(x, y, cells, seeds, seed, find),
            tuple(sys.argv[1:]),
        )
    )
