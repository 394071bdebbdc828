"""One self-contained HTML page of stress runs: opens from disk, needs no network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pjpdaf.targets import TARGETS
from reports.page.episode_tables import episode_tables
from reports.page.page import PLAYER
from reports.page.run_entries import RunEntry, films_left_out, opening_entry, run_entries
from reports.page.templating import rendered, script, shared_scripts, styles, write_made
from reports.run.load import SavedRun, read_film
from reports.stress.load import StressFolder, load_stress
from reports.stress.records import CellRecord, FailureRecord
from reports.stress.sections import (
    FailureCard,
    PlayedFolder,
    Probabilities,
    commands,
    comparisons,
    curves,
    failure_cards,
    headline,
    maps,
    probabilities,
)
from reports.stress.words import interval_text, share_text
from reports.summary.text import count
from reports.words import GOAL_WORDS, MEASURE_WORDS

MOST_VERDICTS = 6  # sentences at the top


@dataclass(frozen=True, eq=False)
class PlayerSection:
    """Episodes of a family in the player's list."""

    name: str
    entries: tuple[RunEntry, ...]


def build_stress_page(folders: Sequence[StressFolder]) -> str:
    """Build the page of one stress run, or of several together. Raises BenchError."""
    played, entries, sections, left_out = _played(folders)
    cards = failure_cards(played)
    estimates = probabilities(played)
    searches = [
        (source.search.system, search)
        for source in folders
        if source.search is not None
        for search in source.search.searches
    ]
    systems = list(dict.fromkeys(_systems(folders)))
    lost = _lost(folders)
    return rendered(
        "stress.html.j2",
        css=styles("player.css", "stage.css", "stress.css"),
        scripts=[*shared_scripts(), script(*PLAYER)],
        title=f"Stress test: {', '.join(systems)}",
        systems=systems,
        outcome="bad" if cards else "good" if searches and not lost else "",
        verdicts=[*_verdicts(searches, cards, estimates), *_mapped(folders)][:MOST_VERDICTS],
        lost=lost,
        tiles=_tiles(folders, searches, cards, estimates),
        searches=searches,
        cards=cards,
        maps=maps(played),
        curves=curves(played),
        probabilities=estimates,
        comparisons=comparisons(played),
        commands=commands(played),
        sections=sections,
        entries=entries,
        opening=opening_entry(entries),
        films_left_out=left_out,
        targets=TARGETS,
        count=count,
        headline=headline,
        goal_words=GOAL_WORDS,
        measure_words=MEASURE_WORDS,
        share_text=share_text,
        interval_text=interval_text,
    )


def write_stress_page(folders: Sequence[Path], path: Path) -> Path:
    """Write the page of stress folders and return its path. Raises BenchError."""
    return write_made(path, lambda: build_stress_page(load_stress(folders)))


def _played(
    folders: Sequence[StressFolder],
) -> tuple[list[PlayedFolder], tuple[RunEntry, ...], list[PlayerSection], int]:
    """The folders with their episodes, all episodes, these by family, and films left out."""
    runs = [f.episodes for f in folders if f.episodes is not None]
    runs = [replace(run, meta={**run.meta, "name": str(n)}) for n, run in enumerate(runs)]
    tables = [{(e.scenario, e.seed): e for e in episode_tables(run)} for run in runs]
    names = list(dict.fromkeys(label for episodes in tables for label, _ in episodes))
    entries = run_entries(runs, tables, names) if runs else ()
    replays = _replays(folders)
    entries = tuple(
        replace(entry, run="", command=replays.get((entry.scenario, entry.seed), ""))
        for entry in entries
    )
    by_key = {entry.key: entry for entry in entries}
    played, number = [], 0
    for folder in folders:
        if folder.episodes is None:
            played.append(PlayedFolder(folder, {}, {}, {}))
            continue
        mine = {
            (label, seed): by_key[f"{number}-{names.index(label)}-{seed}"]
            for label, seed in tables[number]
        }
        played.append(PlayedFolder(folder, mine, tables[number], _films(folder.episodes)))
        number += 1
    families: dict[str, list[RunEntry]] = {}
    for entry in entries:
        family, colon, _ = entry.scenario.partition(":")
        families.setdefault(family if colon else "failures", []).append(entry)
    sections = [PlayerSection(name, tuple(group)) for name, group in families.items()]
    return played, entries, sections, films_left_out(runs, entries)


def _replays(folders: Sequence[StressFolder]) -> dict[tuple[str, int], str]:
    """The command that plays an episode again, by its label and seed."""
    records: list[FailureRecord | CellRecord] = []
    for folder in folders:
        if folder.search is not None:
            records += [f for search in folder.search.searches for f in search.failures]
        if folder.map is not None:
            records += [cell for mapped in folder.map.maps for cell in mapped.cells]
    return {
        (record.episode.label, record.episode.seed): record.command
        for record in records
        if record.episode is not None
    }


def _mapped(folders: Sequence[StressFolder]) -> list[str]:
    """What the maps show, a sentence each."""
    lines = []
    for record in (m for f in folders if f.map is not None for m in f.map.maps):
        n = sum(cell.n for cell in record.cells)
        failed = sum(cell.failures.get(record.goal, 0) for cell in record.cells)
        axes = [axis.name.replace("_", " ") for axis in (record.x, record.y) if axis is not None]
        lines.append(
            f"{record.family}: {GOAL_WORDS[record.goal]} in {failed} of {count(n, 'trial')} over "
            f"{' and '.join(axes)}."
        )
    return lines


def _films(run: SavedRun) -> dict[tuple[str, int], dict[int, bytes]]:
    return {(f["scenario"], int(f["seed"])): read_film(run, f["file"]) for f in run.meta["films"]}


def _systems(folders: Sequence[StressFolder]) -> list[str]:
    """The systems under test, each comparison's two."""
    names = [
        file.system
        for folder in folders
        for file in (folder.search, folder.map, folder.estimate)
        if file is not None
    ]
    for folder in folders:
        for record in folder.compare.comparisons if folder.compare is not None else ():
            names += [record.a, record.b]
    return names


def _verdicts(searches: Any, cards: Sequence[FailureCard], estimates: Probabilities) -> list[str]:
    """What was found, in sentences."""
    lines = []
    if searches:
        runs = sum(search.runs for _, search in searches)
        families = {search.family for _, search in searches}
        tried = [c for c in cards if c.record.confirmed is not None]
        confirmed = sum(c.record.confirmed is True for c in tried)
        line = (
            f"{count(len(cards), 'distinct failure')} in {count(runs, 'run')} of "
            f"{len(families)} {'family' if len(families) == 1 else 'families'}"
        )
        line += f"; {confirmed} of {len(tried)} confirmed in rendered pictures." if tried else "."
        lines.append(line)
    for n, (system, goal) in enumerate(estimates.columns):
        column = {f: record for f, row in estimates.rows.items() if (record := row[n]) is not None}
        worst = max(column.items(), key=lambda item: item[1].p, default=None)
        if worst is not None and worst[1].p > 0:
            family, record = worst
            text = interval_text(record.p, record.low, record.high)
            name = f"{system}: " if len({s for s, _ in estimates.columns}) > 1 else ""
            lines.append(f"{name}{headline(goal)} is highest in {family}: {text}.")
    return lines


def _lost(folders: Sequence[StressFolder]) -> str:
    """How many runs gave no result, and why the first did not; "" where all did."""
    files = [file for f in folders for file in (f.search, f.map, f.estimate, f.compare) if file]
    lost = [file for file in files if file.without_result]
    if not lost:
        return ""
    runs = count(sum(file.without_result for file in lost), "run")
    return f"{runs} without a result, left out of all figures; the first: {lost[0].first_fault}"


def _tiles(
    folders: Sequence[StressFolder],
    searches: Any,
    cards: Sequence[FailureCard],
    estimates: Probabilities,
) -> list[tuple[str, str, bool]]:
    """(name, figure, whether it is bad) of the figures at the top."""
    tiles: list[tuple[str, str, bool]] = []
    mapped = sum(m.runs for f in folders if f.map is not None for m in f.map.maps)
    if searches:
        tiles.append(("runs of the search", f"{sum(s.runs for _, s in searches):,}", False))
        tiles.append(("distinct failures", str(len(cards)), bool(cards)))
        tried = [c for c in cards if c.record.confirmed is not None]
        if tried:
            confirmed = sum(c.record.confirmed is True for c in tried)
            tiles.append(("confirmed in pictures", f"{confirmed} of {len(tried)}", False))
    if mapped:
        tiles.append(("runs of maps and curves", f"{mapped:,}", False))
    records = [r for row in estimates.rows.values() for r in row if r is not None]
    for goal in ("swap", "lost"):
        mine = [r for r in records if r.goal == goal]
        highest = max((r.p for r in mine), default=0.0)
        if highest > 0:
            tiles.append((f"highest {headline(goal)}", share_text(highest), True))
        elif mine:  # nothing failed, which bounds it
            bound = f"below {share_text(max(r.high for r in mine))}"
            tiles.append((f"highest {headline(goal)}", bound, False))
    return tiles[:6]
