"""What a data set has beside its sequences: exports, the one calibration, card, Croissant."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from sim.dataset.export.registry import EXPORTS
from sim.dataset.layout import CALIBRATION
from sim.dataset.reader import Dataset
from sim.files import disk_faults, part_folder


def write_exports(dataset: Dataset, exports: Sequence[str]) -> list[Path]:
    """The data set in other formats; the files of each. Raises BenchError."""
    return [path for name in exports for path in EXPORTS[name](dataset, dataset.folder)]


def write_calibration(dataset: Dataset) -> None:
    """`calib/` of the whole, where all sequences have the same; none where they differ."""
    target = dataset.folder / CALIBRATION
    first, *others = (_texts(sequence.folder / CALIBRATION) for sequence in dataset.sequences)
    with disk_faults(target, "the calibration"):
        shutil.rmtree(target, ignore_errors=True)
        if all(other == first for other in others):
            part = part_folder(target) / CALIBRATION
            shutil.copytree(dataset.sequences[0].folder / CALIBRATION, part)
            part.rename(target)
            part.parent.rmdir()


def _texts(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*.yml"))
    }


def write_top(dataset: Dataset) -> None:
    """All that readers of the whole want."""
    write_calibration(dataset)
