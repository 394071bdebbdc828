"""The verbs of the gate: compare, baseline."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from scenarios.cli.help import SentenceGroup
from scenarios.cli.options import RunFolder


def compare(
    base: Annotated[Path, typer.Argument(metavar="BASE", help="Folder of a saved run.")],
    new: Annotated[Path, typer.Argument(metavar="NEW", help="Another, that must not be worse.")],
    margins: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="YAML file with margins: `margins: {error_mm: 2.5}`."),
    ] = None,
    margin: Annotated[
        list[str] | None,
        typer.Option(metavar="METRIC=VALUE", help="How much worse it may be. Repeatable."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the verdict's files [NEW].")] = None,
    escalate: Annotated[
        bool,
        typer.Option("--escalate", help="Where inconclusive: play more seeds of both."),
    ] = False,
    jobs: Annotated[
        int | None, typer.Option(help="With --escalate: worker processes [all cores].")
    ] = None,
    plug_in: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="With --escalate: a tracker or detector of the runs that may be imported. "
            "Repeatable.",
        ),
    ] = None,
) -> None:
    """The gate: a paired verdict on two saved runs, per metric.

    Writes verdict.json, junit.xml, summary.md, badge.json. Exit code 0: no worse; 1: worse; 3:
    inconclusive; 4: the runs did not play the same.
    """
    from scenarios.run.compare import CompareRequest, compare_runs

    raise typer.Exit(
        compare_runs(
            CompareRequest(
                base=base,
                new=new,
                margins_file=margins,
                margins=tuple(margin or ()),
                out=out,
                escalate=escalate,
                jobs=jobs,
                argv=tuple(sys.argv[1:]),
                plug_ins=tuple(plug_in or ()),
            )
        )
    )


baseline = typer.Typer(
    cls=SentenceGroup,
    help="Accepted runs, which later runs are compared with; small enough for git.",
    no_args_is_help=True,
)


@baseline.callback()
def _baseline() -> None:
    pass  # without it a group of a single verb is that verb


@baseline.command()
def accept(
    run_folder: RunFolder,
    out: Annotated[
        Path | None,
        typer.Argument(metavar="DIR", help="Folder of the baseline [baselines/NAME]."),
    ] = None,
) -> None:
    """Accept a run: put what `compare` needs of it in the place of the baseline before.

    Says what has changed since the baseline before. The folder is replaced as a whole.
    """
    from scenarios.run.accept import AcceptRequest, accept_baseline

    accept_baseline(AcceptRequest(run_folder, out))
