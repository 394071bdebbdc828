"""The verb `dataset show`: a data set as a sheet, as a page, as a recording for Rerun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pjpdaf.errors import BenchError
from reports.dataset.page import dataset_page
from reports.dataset.rerun import write_dataset_rerun
from reports.dataset.sequence_view import SequenceView, sequence_views
from reports.dataset.sheet import dataset_sheet
from reports.pictures.encode import png_of
from reports.summary.text import count
from scenarios.catalogue.frame_choice import representative_frames
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.progress import progress
from sim.dataset.reader import Dataset, open_dataset
from sim.dataset.statistics import statistics_of
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults, written_whole_file

SHEET, PAGE = "sheet.png", "page.html"
MOST_ROWS = 40  # of a sheet; of more sequences these, evenly spread
ROW_FRAMES, ALONE_ROWS = 2, 6  # frames of a row; rows of a sequence that is shown alone


@dataclass(frozen=True)
class ShowDatasetRequest:
    """The options of `dataset show`; None = not given.

    out: a folder for sheet and page, or a file that ends in .png (the sheet) or .html (the page).
    """

    folder: Path
    out: Path | None = None
    sequence: int | None = None
    rerun: Path | None = None


def show_dataset(request: ShowDatasetRequest) -> str:
    """Write sheet, page or recording; returns a line for each file.

    Without `out` and `rerun`: sheet and page in a new folder NAME-show beside the data set. Raises
    BenchError for a data set that cannot be shown or a file that cannot be written,
    InfrastructureError where the disk is full or Rerun is not installed, Interrupted.
    """
    dataset = open_dataset(request.folder)
    sequences = _sequences(dataset, request.sequence)
    sheet, page = _places(request)
    for path in (sheet, page, request.rerun):
        _check_place(path, dataset)
    first = next(path for path in (sheet, page, request.rerun) if path is not None)
    lines = []
    with unwritten_if_interrupted(first):
        if request.rerun is not None:  # first: whether Rerun is there shows at once
            write_dataset_rerun(dataset, sequences, request.rerun)
            lines.append(f"recording: {request.rerun} ({count(len(sequences), 'sequence')})")
        if sheet is not None and page is not None:
            with disk_faults(sheet.parent, "sheet and page"):
                sheet.parent.mkdir(exist_ok=True)
        if sheet is not None:
            lines.append(_write_sheet(sequences, sheet, alone=request.sequence is not None))
        if page is not None:
            lines.append(_write_page(dataset, sequences, page))
    return "\n".join(lines)


def _sequences(dataset: Dataset, number: int | None) -> tuple[StoredSequence, ...]:
    if not dataset.sequences:
        raise BenchError(f"{dataset.folder}: has no finished sequence; there is nothing to show.")
    if number is None:
        return dataset.sequences
    named = {int(s.name.removeprefix("seq_")): s for s in dataset.sequences}
    if number not in named:
        raise BenchError(
            f"--sequence {number}: the data set has {min(named)} to {max(named)}"
            f"{'' if len(named) == max(named) - min(named) + 1 else ', some of them missing'}."
        )
    return (named[number],)


def _places(request: ShowDatasetRequest) -> tuple[Path | None, Path | None]:
    """The paths of sheet and page, None for a file that is not asked for."""
    out = request.out
    if out is None:
        if request.rerun is not None:
            return None, None
        folder = request.folder
        folder = folder.resolve() if folder.name in ("", "..") else folder
        out = folder.with_name(f"{folder.name}-show")
    suffix = out.suffix.lower()
    if suffix == ".png":
        return out, None
    if suffix == ".html":
        return None, out
    return out / SHEET, out / PAGE


def _check_place(path: Path | None, dataset: Dataset) -> None:
    """Raise BenchError, before minutes of work, for a file that must not be written."""
    if path is None:
        return
    if path.resolve().is_relative_to(dataset.folder.resolve()):
        raise BenchError(f"{path}: lies inside the data set, which stays as it is; choose another.")
    if path.exists():
        raise BenchError(f"{path}: exists; give another name, or remove it first.")


def _write_sheet(sequences: Sequence[StoredSequence], path: Path, alone: bool) -> str:
    rows: list[tuple[StoredSequence, list[int]]]
    if alone:
        (sequence,) = sequences
        chosen = representative_frames(sequence.truths, ROW_FRAMES * ALONE_ROWS)
        starts = range(0, len(chosen), ROW_FRAMES)
        rows = [(sequence, chosen[start : start + ROW_FRAMES]) for start in starts]
    else:
        places = np.linspace(0, len(sequences) - 1, min(MOST_ROWS, len(sequences)))
        picked = [sequences[i] for i in places.round().astype(int).tolist()]
        rows = [(s, representative_frames(s.truths, ROW_FRAMES)) for s in picked]
    with (
        progress() as meter,
        written_whole_file(path, "the sheet") as part,
        disk_faults(path, "the sheet"),
    ):
        meter.begin("sheet", None)
        part.write_bytes(png_of(dataset_sheet(rows)))
    shown = len({sequence.name for sequence, _ in rows})
    return f"sheet: {path} ({_share(shown, len(sequences))})"


def _write_page(dataset: Dataset, sequences: Sequence[StoredSequence], path: Path) -> str:
    frames = sum(sequence.frame_count for sequence in sequences)
    with progress() as meter:
        meter.begin("page", frames)
        shown = sequence_views(sequences, on_frame=meter.step)
    whole = Dataset(dataset.folder, dataset.manifest, tuple(sequences))
    title = dataset.folder.resolve().name
    if len(sequences) < len(dataset.sequences):
        title += f", {sequences[0].name}"
    text = dataset_page(whole, statistics_of(whole), shown, title)
    with written_whole_file(path, "the page") as part, disk_faults(path, "the page"):
        part.write_text(text, encoding="utf-8")
    size = path.stat().st_size / 1e6
    return f"page: {path} ({_extent(shown, sequences)}, {size:.1f} MB)"


def _extent(shown: Sequence[SequenceView], sequences: Sequence[StoredSequence]) -> str:
    extent = _share(len(shown), len(sequences))
    if shown[-1].frames < shown[-1].sequence.frame_count:
        extent += f", {shown[-1].frames} of {shown[-1].sequence.frame_count} frames of it"
    return extent


def _share(shown: int, total: int) -> str:
    of_all = "" if shown == total else f" of {total}"
    return f"{shown}{of_all} sequence{'' if total == 1 else 's'}"
