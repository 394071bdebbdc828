"""The formats by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from sim.dataset.export import coco, mot, parquet, webdataset
from sim.dataset.reader import Dataset


class Export(Protocol):
    """Writes a format's folder into `into`, whole or not at all; an older one is replaced.

    on_sequence is called with the name of each sequence once it is written. Gives the files, sorted
    by path. Raises BenchError where the data set is damaged or lacks what the format needs, where a
    library is missing, and of the disk.
    """

    def __call__(
        self, dataset: Dataset, into: Path, on_sequence: Callable[[str], None] = ...
    ) -> list[Path]:
        """Write it."""
        ...


EXPORTS: Mapping[str, Export] = {
    "coco": coco.export,
    "mot": mot.export,
    "webdataset": webdataset.export,
    "parquet": parquet.export,
}
