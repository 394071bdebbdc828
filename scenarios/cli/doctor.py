"""The verb `doctor`."""

from __future__ import annotations

import typer


def doctor() -> None:
    """Check whether this machine can run everything, and name the remedy where it cannot."""
    from scenarios.cli.machine import examine_machine

    findings = examine_machine()
    for finding in findings:
        mark = "ok  " if finding.good else "FAIL"
        typer.echo(f"{mark} {finding.component}: {finding.state}")
        if finding.remedy:
            typer.echo(f"     -> {finding.remedy}")
    if not all(finding.good for finding in findings):
        raise typer.Exit(5)
