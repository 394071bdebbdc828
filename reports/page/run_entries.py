"""Episodes of the runs as the page lists and plays them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from reports.gate.replay import replay_command
from reports.page.enlarged_pictures import EnlargedPicture, enlarged_pictures
from reports.page.episode_tables import EpisodeTables, Key
from reports.page.packed_films import FilmPlace, PackedFilm, packed_films
from reports.page.player import pack, worst_frame
from reports.run.load import SavedRun
from reports.score.ranking import MAX_WORST, badness, film_rank, went_wrong
from reports.summary.text import count
from reports.words import FLAGS


@dataclass(frozen=True, eq=False)
class RunEntry:
    """One episode with a result, as the player and its scenario's table show it.

    key: of its data in the page; run: its name, "" where there is one run; flags: its kinds of
    failure; went_wrong: it belongs among the failures; worst_frame: that of the largest error;
    data: packed for the player; film: its pictures, None where it has none of its own;
    film_owner: key of the entry whose film has the same pictures; command: plays it again, "" where
    the page does not say.
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
    film_owner: str
    pictures: tuple[EnlargedPicture, ...]
    command: str = ""

    @property
    def film_text(self) -> str:
        """The extent of its film in words."""
        if self.film is None:
            return "film" if self.film_owner else "no pictures"
        return "film" if self.film.whole else count(len(self.film.pictures), "picture")


def opening_entry(entries: Sequence[RunEntry]) -> RunEntry | None:
    """The episode that the player opens on: the worst, or None without any."""
    return min(entries, key=_worst_first, default=None)


def worst_entries(entries: Sequence[RunEntry]) -> list[RunEntry]:
    """At most `MAX_WORST` episodes that went wrong, the worst first."""
    return sorted((e for e in entries if e.went_wrong), key=_worst_first)[:MAX_WORST]


def films_left_out(runs: Sequence[SavedRun], entries: Sequence[RunEntry]) -> int:
    """Count the films in the runs' folders that the page has no room for."""
    bare = {
        (int(entry.key.partition("-")[0]), entry.scenario, entry.seed)
        for entry in entries
        if entry.film is None and not entry.film_owner
    }
    films = ((r, film) for r, run in enumerate(runs) for film in run.meta["films"])
    return sum((r, film["scenario"], int(film["seed"])) in bare for r, film in films)


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
    rows = [_rows_of(run) for run in runs]
    orders = [_film_order(mine, episodes) for mine, episodes in zip(rows, played, strict=True)]
    films = packed_films(runs, orders)

    def key_of(r: int, episode: Key) -> str:
        return f"{r}-{place[episode[0]]}-{episode[1]}"

    listed: dict[tuple[int, int, int], RunEntry] = {}
    for r, (run, episodes) in enumerate(zip(runs, played, strict=True)):
        for (scenario, seed), episode in episodes.items():
            mine = rows[r][scenario, seed]
            at = films.get((r, (scenario, seed)), FilmPlace(None))
            shown = at.film or (films[at.owner].film if at.owner is not None else None)
            outside, mean_mm = badness(mine)
            listed[place[scenario], r, seed] = RunEntry(
                key=key_of(r, (scenario, seed)),
                run=run.name if len(runs) > 1 else "",
                scenario=scenario,
                seed=seed,
                flags=_flags(episode.events),
                within_100=1.0 - outside,
                mean_mm=mean_mm,
                went_wrong=went_wrong(mine),
                worst_frame=worst_frame(episode, shown.pictures if shown is not None else ()),
                redraws=int(mine[0]["redrawn"]),
                data=pack(episode),
                film=at.film,
                film_owner=key_of(*at.owner) if at.owner is not None else "",
                pictures=pictures.get((r, scenario, seed), ()),
                command=replay_command(run.meta, scenario, seed),
            )
    return tuple(listed[key] for key in sorted(listed))


def _film_order(
    rows: Mapping[Key, Sequence[Mapping[Any, Any]]], episodes: Iterable[Key]
) -> list[Key]:
    """Episodes in the order in which their films are kept."""
    return sorted(episodes, key=lambda key: film_rank(key, rows[key]))


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
