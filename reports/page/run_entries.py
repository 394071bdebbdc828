"""Episodes of the runs as the page lists and plays them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from reports.page.enlarged_pictures import EnlargedPicture, enlarged_pictures
from reports.page.episode_tables import EpisodeTables, Key
from reports.page.packed_films import FILM_BYTES, STILL_BYTES, PackedFilm, packed_films
from reports.page.player import pack, worst_frame
from reports.run.load import SavedRun
from reports.score.ranking import MAX_WORST, badness, went_wrong, worst_first
from reports.summary.text import count
from reports.words import FLAGS


@dataclass(frozen=True, eq=False)
class RunEntry:
    """One episode with a result, as the player and its scenario's table show it.

    key: of its data in the page; run: its name, "" where there is one run; flags: its kinds of
    failure; went_wrong: it belongs among the failures; worst_frame: that of the largest error;
    data: packed for the player; command: plays it again, "" where the page does not say.
    """

    key: str
    run: str
    scenario: str
    seed: int
    flags: str
    within_100: float
    mean_mm: float
    went_wrong: bool
    worst_frame: int
    redraws: int
    data: str
    film: PackedFilm | None
    pictures: tuple[EnlargedPicture, ...]
    command: str = ""

    @property
    def film_text(self) -> str:
        """The extent of its film in words."""
        if self.film is None:
            return "no pictures"
        return "film" if self.film.whole else count(len(self.film.pictures), "picture")


def opening_entry(entries: Sequence[RunEntry]) -> RunEntry | None:
    """The episode that the player opens on: the worst, or None without any."""
    return min(entries, key=_worst_first, default=None)


def worst_entries(entries: Sequence[RunEntry]) -> list[RunEntry]:
    """At most `MAX_WORST` episodes that went wrong, the worst first."""
    return sorted((e for e in entries if e.went_wrong), key=_worst_first)[:MAX_WORST]


def _worst_first(entry: RunEntry) -> tuple[bool, float, float]:
    return not entry.went_wrong, entry.within_100, -entry.mean_mm


def run_entries(
    runs: Sequence[SavedRun], played: Sequence[Mapping[Key, EpisodeTables]], names: Sequence[str]
) -> tuple[RunEntry, ...]:
    """List all episodes with a result, scenario by scenario, run by run.

    played: the episodes of each run; names: scenarios in order.
    """
    place = {name: n for n, name in enumerate(names)}
    pictures = enlarged_pictures(runs)
    listed: dict[tuple[int, int, int], RunEntry] = {}
    budget = (FILM_BYTES // len(runs), STILL_BYTES // len(runs))
    for r, (run, episodes) in enumerate(zip(runs, played, strict=True)):
        rows = _rows_of(run)
        worst = worst_first(rows)
        films = packed_films(run, [*worst, *(k for k in episodes if k not in worst)], budget)
        for (scenario, seed), episode in episodes.items():
            n = place[scenario]
            film = films.get((scenario, seed))
            outside, mean_mm = badness(rows[scenario, seed])
            listed[n, r, seed] = RunEntry(
                key=f"{r}-{n}-{seed}",
                run=run.name if len(runs) > 1 else "",
                scenario=scenario,
                seed=seed,
                flags=_flags(episode.events),
                within_100=1.0 - outside,
                mean_mm=mean_mm,
                went_wrong=went_wrong(rows[scenario, seed]),
                worst_frame=worst_frame(episode, film.pictures if film is not None else ()),
                redraws=int(rows[scenario, seed][0]["redrawn"]),
                data=pack(episode),
                film=film,
                pictures=pictures.get((r, scenario, seed), ()),
            )
    return tuple(listed[key] for key in sorted(listed))


def _rows_of(run: SavedRun) -> dict[Key, list[Mapping[Any, Any]]]:
    """Rows of the table of episodes by scenario and seed."""
    rows: dict[Key, list[Mapping[Any, Any]]] = {}
    for row in run.episodes.to_dict("records"):
        rows.setdefault((row["scenario"], int(row["seed"])), []).append(row)
    return rows


def _flags(events: pd.DataFrame) -> str:
    """Kinds of failure of an episode in words."""
    kinds = set(events["kind"])
    return ", ".join(text for kind, text in FLAGS.items() if kind in kinds)
