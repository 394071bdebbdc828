"""Labelled stereo data sets on disk: written, read back, verified and exported."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sim.dataset.reader import Dataset


def open(folder: Path | str) -> Dataset:
    """Open a data set: `sim.dataset.reader.open_dataset`, the same records as a live simulation.

    Loaded at the first call: importing the package alone imports nothing.
    """
    from sim.dataset.reader import open_dataset

    return open_dataset(folder)
