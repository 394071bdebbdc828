"""One self-contained HTML page from saved runs: opens from disk, needs no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.gate.verdict import Verdict
from reports.page.episode_tables import EpisodeTables, Key, episode_tables
from reports.page.gate_section import gate_section
from reports.page.headline import headline
from reports.page.run_entries import (
    RunEntry,
    films_left_out,
    opening_entry,
    run_entries,
    worst_entries,
)
from reports.page.run_report import run_report
from reports.page.scenario_sections import scenario_sections
from reports.page.summary_tables import group_table, scenario_table, target_table
from reports.page.templating import rendered, script, shared_scripts, styles, write_made
from reports.page.thesis_figures import ThesisFigure, thesis_figures
from reports.run.load import SavedRun
from reports.summary.text import count

# Parts of the player, each using those before it.
PLAYER = (
    "unpack.js",
    "shared.js",
    "player_data.js",
    "player_marks.js",
    "player_schematic.js",
    "player_view.js",
    "player_paths.js",
    "player_space.js",
    "player_lanes.js",
    "player_curves.js",
    "worst_film.js",
    "player_compare.js",
    "player_address.js",
    "player_controls.js",
    "player_keys.js",
    "player_start.js",
)


def build_page(runs: Sequence[SavedRun], title: str = "", verdict: Verdict | None = None) -> str:
    """Build the page of one run, or of several side by side.

    verdict: the gate's on the run against a baseline, for a page of one run.

    Films and pictures go in as far as the byte limits of `packed_films` and `enlarged_pictures`
    allow, all else whatever its size. Raises BenchError without a run, and where a picture cannot
    be read.
    """
    if not runs:
        raise BenchError("A report needs at least one saved run.")
    runs = _with_unique_names(runs)
    reports = [run_report(run) for run in runs]
    played = [{(e.scenario, e.seed): e for e in episode_tables(run)} for run in runs]
    names = list(dict.fromkeys(name for report in reports for name in report.summary.scenarios))
    entries = run_entries(runs, played, names)
    by_key = {entry.key: entry for entry in entries}
    sections = scenario_sections(reports, entries, names)
    title = title or f"Tracking report: {', '.join(run.name for run in runs)}"
    return rendered(
        "page.html.j2",
        css=styles("player.css", "stage.css"),
        scripts=[*shared_scripts(), script(*PLAYER), script("lightbox.js")],
        title=title,
        reports=reports,
        headlines=[
            headline(report, [e for e in entries if e.key.startswith(f"{r}-")])
            for r, report in enumerate(reports)
        ],
        gate=gate_section(verdict, entries) if verdict is not None else None,
        groups=group_table(reports),
        scenarios=scenario_table(reports, {section.name: section.anchor for section in sections}),
        totals=[
            target_table(f"total-{r}", f"{report.run.name} by target", [("", report.summary.total)])
            for r, report in enumerate(reports)
        ],
        worst=worst_entries(entries),
        wrong=sum(entry.went_wrong for entry in entries),
        opening=opening_entry(entries),
        sections=sections,
        entries=entries,
        films_left_out=films_left_out(runs, entries),
        figures=_figures(played, names, by_key),
        targets=TARGETS,
        count=count,
    )


def write_page(
    runs: Sequence[SavedRun], path: Path, title: str = "", verdict: Verdict | None = None
) -> Path:
    """Write the page and return its path. Raises BenchError where it cannot be written."""
    return write_made(path, lambda: build_page(runs, title, verdict))


def _with_unique_names(runs: Sequence[SavedRun]) -> list[SavedRun]:
    """Number the runs that share a name."""
    names = [run.name for run in runs]
    return [
        replace(run, meta={**run.meta, "name": f"{run.name} ({i + 1})"})
        if names.count(run.name) > 1
        else run
        for i, run in enumerate(runs)
    ]


def _figures(
    played: Sequence[Mapping[Key, EpisodeTables]],
    names: Sequence[str],
    by_key: Mapping[str, RunEntry],
) -> list[tuple[ThesisFigure, RunEntry | None]]:
    """The thesis's figures, each with the episode that it is drawn from."""
    figures: list[tuple[ThesisFigure, RunEntry | None]] = []
    for figure in thesis_figures(played):
        entry = None
        if figure.source is not None:
            r, scenario, seed = figure.source
            entry = by_key[f"{r}-{names.index(scenario)}-{seed}"]
        figures.append((figure, entry))
    return figures
