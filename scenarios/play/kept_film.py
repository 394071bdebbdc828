"""Small films of footage that is in the cache: kept, and not drawn again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from reports.score.records import Still
from scenarios.cache.array_file import Arrays
from scenarios.cache.derived import DerivedCache
from scenarios.cache.folder import Kind
from scenarios.cache.key import film_key
from scenarios.play.footage import Footage, footage_cache, key_of
from scenarios.play.job import Job
from sim.recording.recorder import RecordedSimulation
from sim.recording.recording import Recording


class KeptFilm:
    """The place of an episode's small film in the cache, if it has one there."""

    def __init__(self, job: Job, footage: Footage) -> None:
        cache = footage_cache(job) if job.keep_film else None
        self._store: DerivedCache | None = None
        self._key: Mapping[str, object] = {}
        if cache is not None and isinstance(footage, Recording | RecordedSimulation):
            self._store = DerivedCache(cache.settings, Kind.FILMS)
            self._key = film_key(key_of(job), footage.renderer)

    def read(self) -> tuple[Still, ...] | None:
        """The film, None where there is none."""
        arrays = None if self._store is None else self._store.read(self._key)
        if self._store is None or arrays is None:
            return None
        try:
            return film_from_arrays(arrays)
        except ValueError:
            self._store.drop(self._key)
            return None

    def write(self, film: Sequence[Still]) -> None:
        """Keep a film."""
        if self._store is not None and film:
            self._store.write(self._key, film_to_arrays(film))


def film_to_arrays(film: Sequence[Still]) -> Arrays:
    """Numbers of the frames, sizes of their pictures, and their bytes one after the other."""
    return {
        "frames": np.array([still.frame for still in film], np.int32),
        "sizes": np.array([len(still.webp) for still in film], np.int32),
        "webp": np.frombuffer(b"".join(still.webp for still in film), np.uint8),
    }


def film_from_arrays(arrays: Arrays) -> tuple[Still, ...]:
    """The inverse of `film_to_arrays`. Raises ValueError for other arrays."""
    try:
        frames, sizes, data = arrays["frames"], arrays["sizes"], arrays["webp"].tobytes()
    except KeyError as fault:
        raise ValueError(f"has no {fault}") from fault
    ends = np.cumsum(sizes)
    if frames.shape != sizes.shape or (sizes < 0).any() or ends[-1:].sum() != len(data):
        raise ValueError("its pictures are of other sizes")
    return tuple(
        Still(int(frame), data[end - size : end])
        for frame, size, end in zip(frames, sizes, ends, strict=True)
    )
