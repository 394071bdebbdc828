"""Films of the runs inside the page, as far as its bytes allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from reports.page.episode_tables import Key
from reports.page.packing import base64_text
from reports.run.films import FILM_BYTES
from reports.run.load import SavedRun, read_film

FEWEST_FRAMES = 4  # of a film that is thinned to the room that is left


@dataclass(frozen=True, eq=False)
class PackedFilm:
    """WebP pictures of an episode by frame; whole: it has every frame."""

    pictures: Mapping[int, bytes]
    whole: bool

    @property
    def sizes(self) -> str:
        """Bytes of each frame, such as "0:5120 1:4980"."""
        return " ".join(f"{frame}:{len(webp)}" for frame, webp in self.pictures.items())

    @property
    def packed(self) -> str:
        """The pictures one after the other in base64."""
        return base64_text(b"".join(self.pictures.values()))


@dataclass(frozen=True, eq=False)
class FilmPlace:
    """Where the page has the pictures of an episode.

    film: its own, None where it has those of `owner`, another run's episode of the same pictures.
    """

    film: PackedFilm | None
    owner: tuple[int, Key] | None = None


def packed_films(
    runs: Sequence[SavedRun], orders: Sequence[Sequence[Key]], room: int = FILM_BYTES
) -> dict[tuple[int, Key], FilmPlace]:
    """Films by the number of the run, scenario and seed.

    orders: the episodes of each run, those first whose films are to be there first; room: bytes of
    all films. The runs take turns. Pictures of the same digest and motion are there once. The first
    film that does not fit is thinned evenly to what is left, and is the last.
    """
    stored = [{(f["scenario"], int(f["seed"])): f for f in run.meta["films"]} for run in runs]
    digests = [_digests(run) for run in runs]
    owners: dict[str, tuple[int, Key]] = {}
    places: dict[tuple[int, Key], FilmPlace] = {}
    for r, key in _in_turn(orders):
        if room <= 0 or key not in stored[r]:
            continue
        digest = digests[r].get(key) or f"{r} {key}"
        if digest in owners:
            continue
        pictures = read_film(runs[r], stored[r][key]["file"])
        size = sum(map(len, pictures.values()))
        if size > room:
            pictures = _thinned(pictures, int(len(pictures) * room / size))
            size = room + 1
        if len(pictures) >= min(FEWEST_FRAMES, int(stored[r][key]["frames"])):
            whole = bool(stored[r][key]["whole"]) and size <= room
            places[r, key] = FilmPlace(PackedFilm(pictures, whole))
            owners[digest] = r, key
        room -= size
    for r, order in enumerate(orders):
        for key in order:
            owner = owners.get(digests[r].get(key, ""))
            if owner is not None:
                places.setdefault((r, key), FilmPlace(None, owner))
    return places


def _in_turn(orders: Sequence[Sequence[Key]]) -> list[tuple[int, Key]]:
    """The first of every run, the second of every run, and so on."""
    longest = max(map(len, orders), default=0)
    return [(r, o[n]) for n in range(longest) for r, o in enumerate(orders) if n < len(o)]


def _digests(run: SavedRun) -> dict[Key, str]:
    """Digest and true motion of each episode: the same ones, the same pictures."""
    return {
        (scenario["name"], int(seed)): f"{digest} {truth}"
        for scenario in run.meta["scenarios"]
        for seed, digest, truth in zip(
            scenario["seeds"], scenario["digests"], scenario["truths"], strict=True
        )
        if digest and truth
    }


def _thinned(pictures: Mapping[int, bytes], most: int) -> dict[int, bytes]:
    """At most `most` pictures, evenly spread, the first and the last among them."""
    if len(pictures) <= most:
        return dict(pictures)
    places = np.unique(np.linspace(0, len(pictures) - 1, most).round().astype(int))
    frames = list(pictures)
    return {frames[i]: pictures[frames[i]] for i in places}
