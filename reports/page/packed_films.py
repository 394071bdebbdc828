"""Films of a run inside the page, as far as its bytes allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from reports.page.episode_tables import Key
from reports.page.packing import base64_text
from reports.run.load import SavedRun, read_film

FILM_BYTES = 15_500_000  # of all whole films on a page
STILL_BYTES = 620_000  # of the frames kept of other episodes


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


def packed_films(
    run: SavedRun, order: Sequence[Key], budget: tuple[int, int]
) -> dict[Key, PackedFilm]:
    """Read films of a run in this order as far as the budgets go.

    budget: bytes of whole films and of kept frames. A whole film that does not fit is left out; the
    kept frames of all other episodes are thinned evenly until they fit.
    """
    whole_left, still_left = budget
    entries = {(e["scenario"], int(e["seed"])): e for e in run.meta["films"]}
    whole: dict[Key, PackedFilm] = {}
    kept: dict[Key, dict[int, bytes]] = {}
    for key in [k for k in order if k in entries]:
        entry = entries[key]
        pictures = read_film(run, entry["file"])
        if not entry["whole"]:
            kept[key] = pictures
            continue
        size = sum(map(len, pictures.values()))
        if size <= whole_left:
            whole_left -= size
            whole[key] = PackedFilm(pictures, whole=True)
    most = max((len(p) for p in kept.values()), default=0)
    while most and sum(len(w) for p in kept.values() for w in p.values()) > still_left:
        most -= 1
        kept = {key: _thinned(pictures, most) for key, pictures in kept.items()}
    return whole | {key: PackedFilm(p, whole=False) for key, p in kept.items() if p}


def _thinned(pictures: Mapping[int, bytes], most: int) -> dict[int, bytes]:
    """At most `most` pictures, evenly spread, the first and the last among them."""
    if len(pictures) <= most:
        return dict(pictures)
    places = np.unique(np.linspace(0, len(pictures) - 1, most).round().astype(int))
    frames = list(pictures)
    return {frames[i]: pictures[frames[i]] for i in places}
