"""The verbs of `cache`: info, clear."""

from __future__ import annotations

import typer

from scenarios.cli.help import SentenceGroup

app = typer.Typer(
    cls=SentenceGroup,
    help="Rendered footage with its detections and films, kept so that each is made once. "
    "PJPDAF_BENCH_CACHE: its folder, or off; PJPDAF_BENCH_CACHE_GB: its largest size [5].",
    no_args_is_help=True,
)


@app.command("info")
def info() -> None:
    """Folder, size, episodes of each kind, of which code and renderer; all are checked."""
    from scenarios.cache.report import info_lines, required_settings

    for line in info_lines(required_settings()):
        typer.echo(line)


@app.command("clear")
def clear() -> None:
    """Remove all of it."""
    from rich.filesize import decimal

    from scenarios.cache.folder import CacheFolder
    from scenarios.cache.report import entries_text, required_settings

    removed = CacheFolder(required_settings()).clear()
    typer.echo(f"removed: {entries_text(removed)}, {decimal(sum(e.bytes for e in removed))}")
