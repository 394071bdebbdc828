"""The verb `dataset show`: a data set as a sheet, as a page, as a recording for Rerun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from pjpdaf.errors import BenchError
from reports.dataset.page import dataset_page
from reports.dataset.rerun import write_dataset_rerun
from reports.dataset.sequence_view import SequenceView, sequence_views
from reports.dataset.sheet import dataset_sheet
from reports.pictures.encode import png_of
from reports.summary.text import count
from scenarios.catalogue.frame_choice import representative_frames
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.progress import progress_bar
from sim.dataset.reader import Dataset, open_dataset
from sim.dataset.statistics import statistics_of
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults, written_whole_file

SHEET, PAGE = "sheet.png", "page.html"
MOST_ROWS = 40  # of a sheet; of more sequences these, evenly spread
ROW_FRAMES, ALONE_ROWS = 2, 6  # frames of a row; rows of a sequence that is shown alone


@dataclass(frozen=True)
class ShowDatasetRequest:
    """What the command line asked for; None = not given.

    out: a folder for both, or a file that ends in .png (the sheet) or .html (the page).
    """

    folder: Path
    out: Path | None = None
    sequence: int | None = None
    rerun: Path | None = None


def show_dataset(request: ShowDatasetRequest) -> str:
    """Write what was asked for; what was written, in words. Without `out` and `rerun`: sheet and
    page in a new folder NAME-show here.

    Raises BenchError for what cannot be shown or written, InfrastructureError where the disk is
    full or Rerun is not installed, Interrupted.
    """
    dataset = open_dataset(request.folder)
    sequences = _sequences(dataset, request.sequence)
    sheet, page = _places(request)
    for path in (sheet, page, request.rerun):
        _check_place(path, dataset)
    first = next(path for path in (sheet, page, request.rerun) if path is not None)
    said = []
    with unwritten_if_interrupted(first):
        if request.rerun is not None:  # first: whether Rerun is there shows at once
            write_dataset_rerun(dataset, sequences, request.rerun)
            said.append(f"recording: {request.rerun} ({count(len(sequences), 'sequence')})")
        if sheet is not None and page is not None:
            with disk_faults(sheet.parent, "sheet and page"):
                sheet.parent.mkdir(exist_ok=True)
        if sheet is not None:
            said.append(_write_sheet(sequences, sheet, alone=request.sequence is not None))
        if page is not None:
            said.append(_write_page(dataset, sequences, page))
    return "\n".join(said)


def _sequences(dataset: Dataset, number: int | None) -> tuple[StoredSequence, ...]:
    if not dataset.sequences:
        raise BenchError(f"{dataset.folder}: has no finished sequence; there is nothing to show.")
    if number is None:
        return dataset.sequences
    named = {int(one.name.removeprefix("seq_")): one for one in dataset.sequences}
    if number not in named:
        raise BenchError(
            f"--sequence {number}: the data set has {min(named)} to {max(named)}"
            f"{'' if len(named) == max(named) - min(named) + 1 else ', some of them missing'}."
        )
    return (named[number],)


def _places(request: ShowDatasetRequest) -> tuple[Path | None, Path | None]:
    """Where sheet and page are to lie, None for one that is not wanted."""
    out = request.out
    if out is None:
        if request.rerun is not None:
            return None, None
        out = Path(f"{request.folder.resolve().name}-show")
    suffix = out.suffix.lower()
    if suffix == ".png":
        return out, None
    if suffix == ".html":
        return None, out
    return out / SHEET, out / PAGE


def _check_place(path: Path | None, dataset: Dataset) -> None:
    """What takes minutes is not begun for a place that it cannot be written to."""
    if path is None:
        return
    if path.resolve().is_relative_to(dataset.folder.resolve()):
        raise BenchError(f"{path}: lies inside the data set, which stays as it is; choose another.")
    if path.exists():
        raise BenchError(f"{path}: exists; give another name, or remove it first.")


def _write_sheet(sequences: Sequence[StoredSequence], path: Path, alone: bool) -> str:
    rows: list[tuple[StoredSequence, list[int]]]
    if alone:
        (one,) = sequences
        chosen = representative_frames(one.truths, ROW_FRAMES * ALONE_ROWS)
        starts = range(0, len(chosen), ROW_FRAMES)
        rows = [(one, chosen[start : start + ROW_FRAMES]) for start in starts]
    else:
        places = np.linspace(0, len(sequences) - 1, min(MOST_ROWS, len(sequences)))
        picked = [sequences[i] for i in places.round().astype(int).tolist()]
        rows = [(one, representative_frames(one.truths, ROW_FRAMES)) for one in picked]
    with written_whole_file(path, "the sheet") as part, disk_faults(path, "the sheet"):
        part.write_bytes(png_of(dataset_sheet(rows)))
    shown = len({one.name for one, _ in rows})
    return f"sheet: {path} ({_share(shown, len(sequences))})"


def _write_page(dataset: Dataset, sequences: Sequence[StoredSequence], path: Path) -> str:
    frames = sum(one.frame_count for one in sequences)
    with progress_bar(Console(stderr=True)) as progress:
        task = progress.add_task("page", total=frames)
        shown = sequence_views(sequences, on_frame=lambda: progress.advance(task))
    whole = Dataset(dataset.folder, dataset.manifest, tuple(sequences))
    title = dataset.folder.resolve().name
    if len(sequences) < len(dataset.sequences):
        title += f", {sequences[0].name}"
    text = dataset_page(whole, statistics_of(whole), shown, title)
    with written_whole_file(path, "the page") as part, disk_faults(path, "the page"):
        part.write_text(text, encoding="utf-8")
    size = path.stat().st_size / 1e6
    return f"page: {path} ({_shown_words(shown, sequences)}, {size:.1f} MB)"


def _shown_words(shown: Sequence[SequenceView], sequences: Sequence[StoredSequence]) -> str:
    words = _share(len(shown), len(sequences))
    if shown[-1].frames < shown[-1].sequence.frame_count:
        words += f", {shown[-1].frames} of {shown[-1].sequence.frame_count} frames of it"
    return words


def _share(shown: int, all_of_them: int) -> str:
    of_all = "" if shown == all_of_them else f" of {all_of_them}"
    return f"{shown}{of_all} sequence{'' if all_of_them == 1 else 's'}"
