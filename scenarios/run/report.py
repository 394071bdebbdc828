"""The verb `report`: the page of saved runs once more."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pjpdaf.errors import BenchError
from reports.page.page import write_page
from reports.run.load import load


def remake_report(run_folders: Sequence[Path], out: Path | None) -> Path:
    """Write the page of one run, or of several side by side; its path.

    out: the file; None, of a single run: its report.html. Raises BenchError.
    """
    if out is None and len(run_folders) > 1:
        raise BenchError("a page of several runs is in none of them: give --out FILE.html")
    saved = [load(folder) for folder in run_folders]
    for run in saved:
        if run.slim:
            raise BenchError(f"{run.folder}: is a slim run, without frames; it has no page")
    return write_page(saved, out or run_folders[0] / "report.html")
