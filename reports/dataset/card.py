"""README.md of a data set: the card that the Hugging Face Hub reads, with its pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from reports.dataset.card_prose import (
    conventions_list,
    exactness,
    licence,
    limits,
    loading,
    making,
    overview,
)
from reports.dataset.card_sample import sample_jpeg
from reports.dataset.card_tables import (
    PICTURES,
    SAMPLE,
    file_table,
    front_matter,
    label_tables,
    sequence_table,
)
from reports.dataset.histograms import histogram_svg
from reports.dataset.spread_table import spread_table
from sim.dataset.croissant import NAME
from sim.dataset.files.layout import CARD
from sim.dataset.raytruth import RayFigures
from sim.dataset.reader import Dataset
from sim.dataset.spread import spread_of
from sim.dataset.statistics import Statistics
from sim.files import disk_faults, written_whole_file


def write_card(
    dataset: Dataset,
    statistics: Statistics,
    ray_figures: RayFigures | None = None,
    command: Sequence[str] = (),
) -> str:
    """Write README.md and its pictures into the data set's folder and return its text.

    ray_figures: comparison with independent rays (`sim.dataset.raytruth`), or None.
    command: the words that made the data set; paths are left out. Raises BenchError of the disk
    and of damaged files.
    """
    folder = dataset.folder / PICTURES
    with disk_faults(folder, "the card"):
        folder.mkdir(exist_ok=True)
    _write(folder / SAMPLE, sample_jpeg(dataset))
    for name, histogram in statistics.histograms.items():
        _write(folder / f"{name}.svg", histogram_svg(histogram).encode())
    text = card_text(dataset, statistics, ray_figures, command)
    _write(dataset.folder / CARD, text.encode())
    return text


def card_text(
    dataset: Dataset,
    statistics: Statistics,
    ray_figures: RayFigures | None = None,
    command: Sequence[str] = (),
) -> str:
    """The text of README.md, a function of the data set alone."""
    parts = [
        f"---\n{front_matter(statistics)}---",
        f"# {NAME}",
        overview(dataset, statistics),
        f"![Left view, right view and labels of a few frames]({PICTURES}/{SAMPLE})",
        "## Sequences",
        sequence_table(dataset, statistics),
        "## Labels in numbers",
        label_tables(statistics),
        "## Spread",
        spread_table(dataset, spread_of(dataset)),
        "## Files",
        file_table(dataset),
        "## Loading",
        loading(dataset),
        "## Conventions",
        conventions_list(),
        "## Exactness",
        exactness(ray_figures),
        "## How it was made",
        making(dataset, command),
        "## Limits",
        limits(),
        "## Licence and citation",
        licence(dataset),
    ]
    return "\n\n".join(parts) + "\n"


def _write(path: Path, data: bytes) -> None:
    with written_whole_file(path, "the card", replace=True) as part, disk_faults(path, "the card"):
        part.write_bytes(data)
