"""The command line: the verbs in the order of `--help`; faults become one line and an exit code.

Each verb parses, calls one function and prints; heavy modules are imported inside the verb.
"""

from __future__ import annotations

import errno
import sys
from typing import Annotated

import typer

from pjpdaf.errors import BenchError
from pjpdaf.unforeseen import report_unforeseen
from scenarios.cli import (
    cache,
    dataset,
    doctor,
    footage,
    gate,
    plugin,
    run,
    scenarios,
    stress,
    stress_maps,
)
from scenarios.cli.help import CONTEXT, SentenceGroup
from scenarios.cli.streams import discard_output, surviving_readers

DEBUG = "--debug"

app = typer.Typer(
    name="pjpdaf-bench",
    cls=SentenceGroup,
    context_settings=CONTEXT,
    help="Render a seated person from two calibrated cameras, track head and both hands in 3-D, "
    "and score the result against the exact truth.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for verb in (
    run.run,
    run.merge,
    gate.compare,
    run.report,
    run.score,
    footage.track,
    footage.calibrate,
    doctor.doctor,
):
    app.command()(verb)
app.add_typer(gate.baseline, name="baseline")
app.add_typer(scenarios.app, name="scenarios")
app.add_typer(plugin.app, name="plugin")
app.add_typer(dataset.app, name="dataset")
stress.app.command("map")(stress_maps.map_failures)
stress.app.command()(stress_maps.estimate)
stress.app.command()(stress_maps.compare)
app.add_typer(stress.app, name="stress")
app.add_typer(cache.app, name="cache")


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"pjpdaf-bench {version('pjpdaf-bench')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
    debug: Annotated[
        bool,
        typer.Option("--debug", help="Show the traceback of an unforeseen fault. In any place."),
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command of `sys.argv`; always raises SystemExit with its exit code."""
    with surviving_readers():
        debug = DEBUG in sys.argv[1:]
        # In any place: it is added to the end of a command that has failed.
        sys.argv = [word for word in sys.argv if word != DEBUG]
        try:
            _run_app()
        except Exception as fault:
            raise SystemExit(report_unforeseen(fault, debug)) from None


def _run_app() -> None:
    try:
        app(standalone_mode=True)
    except BenchError as fault:
        sys.stderr.write(f"pjpdaf-bench: {fault}\n")
        raise SystemExit(fault.exit_code) from None
    except KeyboardInterrupt:
        sys.stderr.write("pjpdaf-bench: interrupted\n")
        raise SystemExit(130) from None
    except OSError as fault:
        if fault.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise
        discard_output(sys.stdout)
        sys.stderr.write(f"pjpdaf-bench: cannot write the output: {fault.strerror}\n")
        raise SystemExit(5) from None


if __name__ == "__main__":
    main()
