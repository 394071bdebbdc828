"""Films of a saved run: a ZIP of WebP frames an episode."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from reports.run.rows import EpisodeRows
from reports.score.ranking import worst_first


def write_films(part: Path, rows: Sequence[EpisodeRows]) -> list[dict[str, Any]]:
    """Write the films that are kept into the folder `part`; return their entries of run.json."""
    kept = films_to_keep(rows)
    index = []
    for number, row in enumerate(rows):
        if not row.film or (row.scenario, row.seed) not in kept:
            continue
        file = f"films/{number:04d}_{plain_name(row.scenario)}_{row.seed}.zip"
        (part / file).parent.mkdir(exist_ok=True)
        with zipfile.ZipFile(part / file, "w", zipfile.ZIP_STORED) as film:
            for still in sorted(row.film, key=lambda s: s.frame):
                # ZipInfo's own date is fixed: equal frames, equal bytes.
                film.writestr(zipfile.ZipInfo(f"{still.frame:05d}.webp"), still.webp)
        index.append(
            {
                "scenario": row.scenario,
                "seed": row.seed,
                "frames": len(row.film),
                "whole": len(row.film) == row.frame_count,
                "file": file,
            }
        )
    return index


def films_to_keep(rows: Iterable[EpisodeRows]) -> set[tuple[str, int]]:
    """(scenario, seed) of the episodes whose films are kept: every first seed and the worst.

    More rows never bring back an episode that is not among them.
    """
    episodes = {(row.scenario, row.seed): row.episodes for row in rows}
    first: dict[str, int] = {}
    for scenario, seed in episodes:
        first[scenario] = min(seed, first.get(scenario, seed))
    return {*first.items(), *worst_first(episodes)}


def plain_name(scenario: str) -> str:
    """Turn a scenario's name into a file name's letters, digits, dashes and underscores."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", scenario)[:60]
