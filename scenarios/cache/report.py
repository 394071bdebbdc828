"""What the cache says of itself: the line of a run, and `cache info`."""

from __future__ import annotations

import time
from collections.abc import Iterator

from rich.filesize import decimal

from pjpdaf.errors import BenchError, FileError
from reports.run.rows import EpisodeRows
from reports.summary.text import count
from scenarios.cache.key import library_versions
from scenarios.cache.settings import CacheSettings, cache_settings
from scenarios.cache.sources import simulator_digest
from scenarios.cache.store import Entry, FootageCache
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
        return "footage: all from the cache, nothing rendered (--no-cache renders anew)"
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


def info_lines(settings: CacheSettings) -> Iterator[str]:
    """Yield the lines of `cache info`. Every entry is read and checked."""
    entries = FootageCache(settings).entries()
    size = sum(entry.bytes for entry in entries)
    yield f"folder: {settings.folder}"
    yield f"size: {decimal(size)} of at most {decimal(settings.limit_bytes)}"
    yield f"entries: {count(len(entries), 'episode')}"
    if not entries:
        return
    footers = [footer for entry in entries if (footer := _footer(entry)) is not None]
    frames = sum(len(footer.events) for footer in footers)
    yield f"frames: {count(frames, 'stereo frame')}, {size / max(frames, 1) / 1e3:.0f} kB each"
    now = {"simulator": simulator_digest(), "libraries": library_versions()}
    current = sum(all(footer.key.get(k) == v for k, v in now.items()) for footer in footers)
    yield f"of this version: {count(current, 'episode')}; others are dropped as they age"
    yield f"damaged: {count(len(entries) - len(footers), 'episode')}"
    for renderer in sorted({footer.renderer for footer in footers}):
        yield f"renderer: {renderer}"
    yield f"longest unused: {(time.time() - entries[0].used_s) / 86400:.1f} days"


def _footer(entry: Entry) -> Footer | None:
    try:
        with Recording(entry.path) as recording:
            return recording.footer
    except (FileError, OSError):
        return None
