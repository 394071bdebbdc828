"""Folders of stress runs: their files and the saved run of the episodes that the page plays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pjpdaf.errors import BenchError
from reports.run.load import SavedRun, load
from reports.stress.records import (
    CompareFile,
    EstimateFile,
    MapFile,
    SearchFile,
    read_record,
)

EPISODES = "episodes"  # that a search shows
MAP_EPISODES = "map_episodes"  # of a map: both verbs may have the same folder
FILES = ("failures.json", "map.json", "estimate.json", "compare.json")


@dataclass(frozen=True, eq=False)
class StressFolder:
    """What is in a folder of a stress run; a verb that was not run there has no file.

    episodes: those that the page plays.
    """

    folder: Path
    search: SearchFile | None
    map: MapFile | None
    estimate: EstimateFile | None
    compare: CompareFile | None
    episodes: SavedRun | None


def is_stress_folder(folder: Path) -> bool:
    """Whether a verb of stress has saved its results there."""
    return any((folder / name).is_file() for name in FILES)


def load_stress(folders: Sequence[Path]) -> list[StressFolder]:
    """Read folders. Raises BenchError naming the file that is missing, damaged or foreign."""
    return [loaded for folder in folders for loaded in _load(folder)]


def _load(folder: Path) -> list[StressFolder]:
    """What is in a folder; its map apart, with the episodes of its own."""
    if not is_stress_folder(folder):
        raise BenchError(f"{folder}: is no folder of a stress run: it has none of {FILES}.")
    mapped = read_record(folder / "map.json", MapFile)
    all_of_it = StressFolder(
        folder,
        read_record(folder / "failures.json", SearchFile),
        mapped,
        read_record(folder / "estimate.json", EstimateFile),
        read_record(folder / "compare.json", CompareFile),
        _episodes(folder / EPISODES),
    )
    episodes = _episodes(folder / MAP_EPISODES)
    if mapped is None or episodes is None:
        return [all_of_it]
    others = replace(all_of_it, map=None)
    own = StressFolder(folder, None, mapped, None, None, episodes)
    return [others, own] if others.search or others.estimate or others.compare else [own]


def _episodes(folder: Path) -> SavedRun | None:
    return load(folder) if (folder / "run.json").is_file() else None
