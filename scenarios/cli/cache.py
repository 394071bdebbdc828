"""The verbs of `cache`: info, clear."""

from __future__ import annotations

import typer

from scenarios.cli.help import SentenceGroup

app = typer.Typer(
    cls=SentenceGroup,
    help="Rendered footage, kept so that it is rendered once. PJPDAF_BENCH_CACHE: its folder, or "
    "off; PJPDAF_BENCH_CACHE_GB: its largest size [5].",
    no_args_is_help=True,
)


@app.command("info")
def info() -> None:
    """Folder, size, number of episodes, of which code and renderer; all are checked."""
    from scenarios.cache.report import info_lines, required_settings

    for line in info_lines(required_settings()):
        typer.echo(line)


@app.command("clear")
def clear() -> None:
    """Remove all of it."""
    from rich.filesize import decimal

    from reports.summary.text import count
    from scenarios.cache.report import required_settings
    from scenarios.cache.store import FootageCache

    removed, size = FootageCache(required_settings()).clear()
    typer.echo(f"removed: {count(removed, 'episode')}, {decimal(size)}")
