"""Films of a saved run: a ZIP of WebP frames an episode, all of them within a fixed room."""

from __future__ import annotations

import re
import zipfile
from bisect import insort
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from reports.run.rows import EpisodeRows
from reports.score.ranking import FilmRank, film_rank

FILM_BYTES = 10_000_000  # of all films of a run: about 2300 frames of two views


class FilmShelf:
    """Chooses the films that a run keeps, while its episodes come in any order.

    The first films by `film_rank` are kept, as far as `room` bytes go; the first that does not fit
    is the end. More episodes only push others back, so the choice does not depend on their order.
    """

    def __init__(self, room: int = FILM_BYTES) -> None:
        self._left = room
        self._kept: list[tuple[FilmRank, int, int]] = []  # rank, index, bytes
        self._end: FilmRank | None = None  # of the first film that is not kept

    def add(self, index: int, rows: EpisodeRows) -> list[int]:
        """Give an episode's film a place; the indices of films that are not kept, or no longer."""
        rank = _rank(rows)
        if self._end is not None and rank >= self._end:
            return [index]
        size = sum(len(still.webp) for still in rows.film)
        insort(self._kept, (rank, index, size))
        self._left -= size
        return self._dropped()

    def close(self, rows: EpisodeRows) -> list[int]:
        """End before an episode whose film was dropped already; indices as of `add`."""
        rank = _rank(rows)
        self._end = rank if self._end is None else min(self._end, rank)
        return self._dropped()

    def _dropped(self) -> list[int]:
        """Take away what lies behind the end, and what has no room, from the last on."""
        dropped = []
        while self._kept and (
            self._left < 0 or (self._end is not None and self._kept[-1][0] >= self._end)
        ):
            rank, index, size = self._kept.pop()
            self._end = rank if self._end is None else min(self._end, rank)
            self._left += size
            dropped.append(index)
        return dropped


def films_to_keep(rows: Sequence[EpisodeRows], room: int = FILM_BYTES) -> set[int]:
    """Places of the rows whose films are kept: see `FilmShelf`."""
    shelf = FilmShelf(room)
    kept = {index for index, row in enumerate(rows) if row.film}
    for index in sorted(kept):
        kept.difference_update(shelf.add(index, rows[index]))
    return kept


def write_films(part: Path, rows: Sequence[EpisodeRows]) -> list[dict[str, Any]]:
    """Write the films that are kept into the folder `part`; return their entries of run.json."""
    index = []
    for number in sorted(films_to_keep(rows)):
        row = rows[number]
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


def plain_name(scenario: str) -> str:
    """Turn a scenario's name into a file name's letters, digits, dashes and underscores."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", scenario)[:60]


def _rank(rows: EpisodeRows) -> FilmRank:
    return film_rank((rows.scenario, rows.seed), rows.episodes)
