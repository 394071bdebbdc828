"""Folders of stress runs: their files and the saved run of the episodes that the page plays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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

EPISODES = "episodes"
FILES = ("failures.json", "map.json", "estimate.json", "compare.json")


@dataclass(frozen=True, eq=False)
class StressFolder:
    """What is in a folder of a stress run; a verb that was not run there has no file."""

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
    return [_load(folder) for folder in folders]


def _load(folder: Path) -> StressFolder:
    if not is_stress_folder(folder):
        raise BenchError(f"{folder}: is no folder of a stress run: it has none of {FILES}.")
    episodes = folder / EPISODES
    return StressFolder(
        folder,
        read_record(folder / "failures.json", SearchFile),
        read_record(folder / "map.json", MapFile),
        read_record(folder / "estimate.json", EstimateFile),
        read_record(folder / "compare.json", CompareFile),
        load(episodes) if (episodes / "run.json").is_file() else None,
    )
