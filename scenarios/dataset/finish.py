"""What a data set has beside its sequences: exports, the one calibration, card, Croissant."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path

from reports.dataset.card import write_card
from sim.dataset.croissant import CROISSANT, croissant_record
from sim.dataset.export.registry import EXPORTS
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import CALIBRATION, CONVENTIONS
from sim.dataset.raytruth import RayFigures
from sim.dataset.reader import Dataset
from sim.dataset.statistics import statistics_of
from sim.files import disk_faults, part_folder, written_whole_file


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


def write_top(dataset: Dataset, argv: Sequence[str], rays: RayFigures | None = None) -> None:
    """All that readers of the whole want: conventions, calibration, Croissant, the card.

    argv: of the command that made it; rays: what `dataset verify` found. Raises BenchError.
    """
    write_text(dataset.folder / CONVENTIONS, json.dumps(conventions(), indent=1) + "\n")
    write_calibration(dataset)
    write_text(dataset.folder / CROISSANT, json.dumps(croissant_record(dataset), indent=1) + "\n")
    write_card(dataset, statistics_of(dataset), rays, command=argv)


def write_text(path: Path, text: str) -> None:
    """Write or replace a file, whole or not at all. Raises BenchError of the disk."""
    with written_whole_file(path, "the data set", replace=True) as part:
        part.write_text(text, encoding="utf-8")
