"""The verb of `plugin`: check."""

from __future__ import annotations

from typing import Annotated

import typer

from scenarios.cli.help import SentenceGroup

app = typer.Typer(
    cls=SentenceGroup, help="Trackers, detectors and motions of your own.", no_args_is_help=True
)


@app.command("check")
def check(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Entry point or module:factory.")],
    kind: Annotated[str, typer.Option(help="tracker, detector or motion.")] = "tracker",
    limit: Annotated[float, typer.Option(help="How long one call may take [s].")] = 10.0,
) -> None:
    """Check a tracker, detector or kind of motion: every fault is a line; exit code 1 then."""
    from pjpdaf.plugins.conformance import LONGEST_LIMIT_S, check_limit, check_named
    from pjpdaf.plugins.loading import allow_plug_ins_from_here
    from scenarios.execute.isolated import Ended, isolated

    allow_plug_ins_from_here(name)
    try:
        # The limit of the whole ends a plug-in that hangs between its calls.
        plug_in = f"{kind} {name!r}"
        if kind == "motion":
            from scenarios.catalogue.motion_check import check_motion

            check_limit(limit)
            faults = isolated(plug_in, LONGEST_LIMIT_S, check_motion, name, limit)
        else:
            faults = isolated(plug_in, LONGEST_LIMIT_S, check_named, kind, name, limit)
    except Ended as end:
        faults = (str(end),)
    for fault in faults:
        typer.echo(fault)
    if faults:
        raise typer.Exit(1)
    typer.echo(f"ok: {kind} {name}")
