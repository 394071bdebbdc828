"""The verb `doctor`."""

from __future__ import annotations

import typer


def doctor() -> None:
    """Say whether this machine can run everything, and what to install where it cannot."""
    from scenarios.cli.machine import examine

    findings = examine()
    for finding in findings:
        mark = "ok  " if finding.good else "FAIL"
        typer.echo(f"{mark} {finding.what}: {finding.found}")
        if finding.remedy:
            typer.echo(f"     -> {finding.remedy}")
    if not all(finding.good for finding in findings):
        raise typer.Exit(5)
