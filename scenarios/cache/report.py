"""What the cache says of itself: the line of a run, and `cache info`."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rich.filesize import decimal

from pjpdaf.errors import BenchError, FileError
from reports.run.rows import EpisodeRows
from reports.summary.text import count
from scenarios.cache.array_file import arrays_from_bytes
from scenarios.cache.folder import CacheFolder, Entry, Kind
from scenarios.cache.key import library_versions
from scenarios.cache.settings import CacheSettings, cache_settings
from scenarios.cache.sources import simulator_digest
from sim.recording.footer import Footer
from sim.recording.recording import Recording


def origin_line(
    rows: tuple[EpisodeRows, ...], settings: CacheSettings | None, plugged: int = 0
) -> str:
    """Where the pictures of a run came from, "" where nothing was rendered or replayed.

    plugged: number of episodes whose motion is a plug-in's.
    """
    drawn = [row for row in rows if row.renderer]
    replayed = sum(row.replayed for row in drawn)
    if settings is None or not drawn:
        return ""
    if plugged:
        anew = f"{count(plugged, 'episode')} with a plug-in's motion rendered anew, not kept"
        others = f"; {replayed} of the others from the cache" if replayed else ""
        return f"footage: {anew} (the cache cannot know all of its code){others}"
    if replayed == len(drawn):
        detected = "" if all(row.detections_kept for row in drawn) else ", but detected anew"
        return f"footage: all from the cache, nothing rendered{detected} (--no-cache renders anew)"
    share = f"{replayed} of {len(drawn)} from the cache, the rest" if replayed else "rendered and"
    return f"footage: {share} kept for the next run in {settings.folder} (--no-cache: neither)"


def required_settings() -> CacheSettings:
    """The settings of this environment. Raises BenchError where the cache is off."""
    settings = cache_settings()
    if settings is None:
        raise BenchError(
            "the cache is off: PJPDAF_BENCH_CACHE=off, or there is no home folder; set it to a "
            "folder"
        )
    return settings


def entries_text(entries: Sequence[Entry]) -> str:
    """Number of the entries of each kind."""
    numbers = [sum(entry.kind == kind for entry in entries) for kind in Kind]
    return ", ".join(
        f"{kind} of {count(number, 'episode')}" for kind, number in zip(Kind, numbers, strict=True)
    )


def info_lines(settings: CacheSettings) -> Iterator[str]:
    """Yield the lines of `cache info`. Every entry is read and checked."""
    entries = CacheFolder(settings).entries()
    size = sum(entry.bytes for entry in entries)
    yield f"folder: {settings.folder}"
    yield f"size: {decimal(size)} of at most {decimal(settings.limit_bytes)}"
    yield f"entries: {entries_text(entries)}"
    if not entries:
        return
    footers = [
        footer
        for entry in entries
        if entry.kind == Kind.FOOTAGE and (footer := _footer(entry)) is not None
    ]
    frames = sum(len(footer.events) for footer in footers)
    kept = [derived for entry in entries if (derived := _derived(entry)) is not None]
    yield f"footage: {count(frames, 'stereo frame')}, {_each_kb(entries, Kind.FOOTAGE, frames)}"
    for kind in (Kind.DETECTIONS, Kind.FILMS):
        frames = sum(len({*one.frames}) for one in kept if one.kind == kind)
        yield f"{kind}: {count(frames, 'stereo frame')}, {_each_kb(entries, kind, frames)}"
    now = {"simulator": simulator_digest(), "libraries": library_versions()}
    current = sum(all(footer.key.get(k) == v for k, v in now.items()) for footer in footers)
    yield f"of this version: {count(current, 'episode')}; others are dropped as they age"
    yield f"damaged: {count(len(entries) - len(footers) - len(kept), 'file')}"
    for renderer in sorted({footer.renderer for footer in footers}):
        yield f"renderer: {renderer}"
    yield f"longest unused: {(time.time() - entries[0].used_s) / 86400:.1f} days"


class _Derived(NamedTuple):
    """A whole entry beside footage: its kind, the numbers of its frames, if it is of frames."""

    kind: Kind
    frames: list[int]


def _each_kb(entries: Sequence[Entry], kind: Kind, frames: int) -> str:
    """Bytes of a frame."""
    size = sum(entry.bytes for entry in entries if entry.kind == kind)
    return f"{size / max(frames, 1) / 1e3:.1f} kB each"


def _footer(entry: Entry) -> Footer | None:
    try:
        with Recording(entry.path) as recording:
            return recording.footer
    except (FileError, OSError):
        return None


def _derived(entry: Entry) -> _Derived | None:
    """What an entry beside footage has, None for footage, and where it is damaged."""
    if entry.kind == Kind.FOOTAGE:
        return None
    try:
        _, arrays = arrays_from_bytes(entry.path.read_bytes())
        frames = [] if entry.kind == Kind.SCENES else arrays["frames"].tolist()
        return _Derived(entry.kind, frames)
    except (OSError, ValueError, KeyError):
        return None
