"""The verbs of `stress`: search, shrink, replay, promote; the others: `stress_maps`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pjpdaf.errors import BenchError
from pjpdaf.presets.names import DEFAULT_PRESET
from scenarios.cli.help import SentenceGroup
from scenarios.cli.options import Cluster, Jobs, PlugInName, PresetName

if TYPE_CHECKING:  # the verbs import it when they run: `--help` is quick
    from scenarios.stress.campaign import CampaignRequest

# Of `scenarios.stress.families`, which `--help` does not import; a test holds them equal.
FAMILY_NAMES = (
    *("cross", "bounce", "merge_and_hold", "drink", "both_hands_to_head", "mirror", "parallel"),
    *("fast_finish", "one_view_occluder", "object_splits_hand", "roll_forearms", "recorded"),
    "nuisances",
)


class TargetFirst(SentenceGroup):
    """`stress FAMILY VERB`; `stress VERB FAMILY` as well."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the target first."""
        verbs = self.list_commands(ctx)
        if len(args) > 1 and args[0] in verbs and args[1] not in verbs:
            if "--help" in args:  # of the verb, whatever the target
                args = ["all", args[0], "--help"]
            elif not args[1].startswith("-"):
                args = [args[1], args[0], *args[2:]]
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=TargetFirst,
    no_args_is_help=True,
    subcommand_metavar="VERB [OPTIONS]",
    help="Hunt the cases in which a tracker fails: find, shrink, replay, keep them.",
)

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Fix a scenario parameter, or change detector.NAME / tracker.NAME. Repeatable.",
    ),
]
Also = Annotated[
    list[str] | None,
    typer.Option("--also", metavar="NAME", help="Let this parameter vary too, as fps. Repeatable."),
]
Ranges = Annotated[
    list[str] | None,
    typer.Option("--range", metavar="NAME=LOW..HIGH", help="Narrow a range. Repeatable."),
]
FidelityName = Annotated[
    str | None,
    typer.Option(help="fast: without pictures; full: rendered [fast; full for a detector plug-in]"),
]
Seed = Annotated[int, typer.Option(help="The seed of the whole campaign.")]
StressOut = Annotated[
    Path | None, typer.Option(help="Folder of the results [runs/stress-FAMILY-VERB-DIGEST].")
]
CaseDetector = Annotated[
    str | None,
    typer.Option(help="Instead of the case's; also to allow its module:factory, which is code."),
]
CaseTracker = Annotated[
    str | None,
    typer.Option(help="Likewise; that of a preset brings its detector."),
]
TimeLimit = Annotated[float, typer.Option(help="How long one episode may take [s].")]


@app.callback()
def _target(
    ctx: typer.Context,
    target: Annotated[
        str,
        typer.Argument(
            metavar="FAMILY|all|CASE.yaml",
            help=f"What to stress: families with commas between them ({', '.join(FAMILY_NAMES)}; "
            "any other scenario, a scenario file, module:factory of a motion), or a case.",
        ),
    ],
) -> None:
    ctx.obj = target


def fidelity_named(name: str | None) -> Any:
    """fast, full or None. Raises BenchError."""
    if name not in (None, "fast", "full"):
        raise BenchError(f"--fidelity {name}: must be fast or full")
    return name


def campaign_of(
    verb: str,
    ctx: typer.Context,
    detector: str,
    tracker: str,
    *,
    settings: list[str] | None,
    also: list[str] | None,
    ranges: list[str] | None = None,
    fidelity: str | None,
    against: str | None = None,
    **others: Any,
) -> CampaignRequest:
    """The campaign of a verb by its options. others: seed, jobs, cluster, out, time_limit_s."""
    from scenarios.stress.campaign import CampaignRequest

    return CampaignRequest(
        verb,
        ctx.obj,
        detector,
        tracker,
        settings=tuple(settings or ()),
        also=tuple(also or ()),
        ranges=tuple(ranges or ()),
        fidelity=fidelity_named(fidelity),
        against=against,
        **others,
    )


@app.command("search")
def search(
    ctx: typer.Context,
    preset: PresetName = DEFAULT_PRESET,
    detector: PlugInName = None,
    tracker: PlugInName = None,
    against: Annotated[
        str | None,
        typer.Option(metavar="TRACKER", help="Only what this tracker does not fail counts."),
    ] = None,
    find: Annotated[
        str, typer.Option(metavar="A,B", help="Of swap, head (a swap with it), lost; or all.")
    ] = "all",
    budget: Annotated[
        int, typer.Option(help="Runs a family, what narrows failures down included.")
    ] = 500,
    distinct: Annotated[int, typer.Option(help="End with so many distinct failures.")] = 20,
    patience: Annotated[int, typer.Option(help="End after so many runs without a new one.")] = 2000,
    confirm: Annotated[int, typer.Option(help="Failures a family to render.")] = 8,
    no_corpus: Annotated[
        bool, typer.Option("--no-corpus", help="Do not begin with the corpus's cases.")
    ] = False,
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
    """Search for distinct failures, confirm them rendered, list them.

    The same command goes on where it was interrupted.
    """
    from scenarios.stress.search_verb import SearchRequest, search_verb

    search_verb(
        SearchRequest(
            campaign_of(
                "search",
                ctx,
                detector or preset,
                tracker or preset,
                settings=settings,
                also=also,
                ranges=ranges,
                fidelity=fidelity,
                against=against,
                seed=seed,
                jobs=jobs,
                cluster=cluster,
                out=out,
                time_limit_s=time_limit,
            ),
            find,
            budget,
            distinct,
            patience,
            confirm,
            not no_corpus,
            tuple(sys.argv[1:]),
        )
    )


@app.command("shrink")
def shrink(
    ctx: typer.Context,
    fresh: Annotated[int, typer.Option(help="Further noise seeds for the survival rates.")] = 100,
    detector: CaseDetector = None,
    tracker: CaseTracker = None,
    fidelity: FidelityName = None,
    seed: Seed = 0,
    jobs: Jobs = None,
    cluster: Cluster = None,
    out: StressOut = None,
    time_limit: TimeLimit = 900.0,
) -> None:
    """Shrink CASE.yaml: fewest changes from nominal, then smaller ones, then fewest frames.

    It must fail with 6 of 8 fresh noise seeds, else what it needs with its own is named. At most
    150 runs; writes minimal.yaml, severe.yaml.
    """
    from scenarios.stress.campaign import CampaignRequest
    from scenarios.stress.shrink_verb import ShrinkRequest, shrink_verb

    campaign = CampaignRequest(
        "shrink",
        ctx.obj,
        fidelity=fidelity_named(fidelity),
        seed=seed,
        jobs=jobs,
        cluster=cluster,
        out=out,
        time_limit_s=time_limit,
    )
    shrink_verb(ShrinkRequest(campaign, Path(ctx.obj), fresh, detector, tracker))


@app.command("replay")
def replay(
    ctx: typer.Context,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Of a FAMILY: a value that is not nominal; detector.NAME, tracker.NAME.",
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Another noise seed [the file's; 0].")] = None,
    preset: Annotated[
        str | None, typer.Option(help="Detector and tracker of this preset [the file's; default].")
    ] = None,
    detector: CaseDetector = None,
    tracker: CaseTracker = None,
    fidelity: Annotated[
        str | None, typer.Option(help="fast: without pictures; full: rendered [full].")
    ] = None,
    film: Annotated[
        Path | None, typer.Option(metavar="OUT.mp4", help="Film it, estimates and truth drawn in.")
    ] = None,
    time_limit: TimeLimit = 900.0,
) -> None:
    """Play a case again: CASE.yaml, or a FAMILY with values. The same case gives the same bytes."""
    from scenarios.stress.replay import ReplayRequest, replay_verb

    replay_verb(
        ReplayRequest(
            ctx.obj,
            tuple(settings or ()),
            seed,
            detector or preset,
            tracker or preset,
            fidelity_named(fidelity) or "full",
            film,
            time_limit,
        )
    )


@app.command("promote")
def promote(
    ctx: typer.Context,
    name: Annotated[str | None, typer.Option(help="Its name in the corpus [the file's].")] = None,
    corpus: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the corpus [the shipped one].")
    ] = None,
    fixed: Annotated[
        bool, typer.Option("--fixed", help="Put it in as fixed: it must not fail any more.")
    ] = False,
    detector: CaseDetector = None,
    tracker: CaseTracker = None,
) -> None:
    """Put CASE.yaml into the corpus, if it fails when it is rendered."""
    from scenarios.stress.replay import promote as put_in

    status = "fixed" if fixed else "open"
    put = put_in(Path(ctx.obj), name, corpus, status, detector, tracker)
    typer.echo(f"corpus: {put}")
