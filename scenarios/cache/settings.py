"""Where the cache lies and how large it may grow, from the environment."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError

FOLDER_VARIABLE, SIZE_VARIABLE = "PJPDAF_BENCH_CACHE", "PJPDAF_BENCH_CACHE_GB"
OFF = "off"
DEFAULT_GB = 5.0


@dataclass(frozen=True)
class CacheSettings:
    """Folder and most bytes of the cache."""

    folder: Path
    limit_bytes: int


def cache_settings(environment: Mapping[str, str] = os.environ) -> CacheSettings | None:
    """The settings of this environment; None where the cache is off, or there is no home folder.

    Raises BenchError for a size that is none.
    """
    named = environment.get(FOLDER_VARIABLE, "")
    if named.lower() == OFF:
        return None
    folder = Path(named).absolute() if named else _default_folder(environment)
    text = environment.get(SIZE_VARIABLE, "") or str(DEFAULT_GB)
    try:
        size_gb = float(text)
    except ValueError:
        size_gb = math.nan
    if not 0 < size_gb <= 1e6:
        raise BenchError(f"{SIZE_VARIABLE} must be above 0, at most 1e6 GB, got {text[:40]!r}")
    return None if folder is None else CacheSettings(folder, round(size_gb * 1e9))


def _default_folder(environment: Mapping[str, str]) -> Path | None:
    base = environment.get("XDG_CACHE_HOME", "")
    if not Path(base).is_absolute():  # the standard has such a value ignored
        try:
            base = str(Path.home() / ".cache")
        except RuntimeError:
            return None
    return Path(base) / "pjpdaf-bench"
