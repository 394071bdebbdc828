"""The verb `report`: the page of saved runs, or of stress runs, once more."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pjpdaf.errors import BenchError
from reports.gate.gate import compare
from reports.page.page import write_page
from reports.run.load import load
from reports.stress.load import is_stress_folder
from reports.stress.page import write_stress_page
from scenarios.console.progress import progress
from scenarios.execute.journal import FILE as JOURNAL


def remake_report(
    run_folders: Sequence[Path], out: Path | None, baseline: Path | None = None
) -> Path:
    """Write the page of one run, or of several side by side; its path.

    Folders of stress runs give one stress page. out: the file; None, of a single run: its
    report.html (stress.html). baseline: a saved run; the page says the gate's verdict on its one
    run against it. Raises BenchError, NotComparable.
    """
    if out is None and len(run_folders) > 1:
        raise BenchError("a page of several runs is in none of them: give --out FILE.html")
    if baseline is not None and len(run_folders) > 1:
        raise BenchError("--baseline goes with a page of one run")
    with progress() as meter:
        meter.begin("writing the page", None)
        return _write(run_folders, out, baseline)


def _write(run_folders: Sequence[Path], out: Path | None, baseline: Path | None) -> Path:
    stressed = [is_stress_folder(folder) for folder in run_folders]
    if all(stressed):
        if baseline is not None:
            raise BenchError(f"{run_folders[0]}: is a stress run, which no baseline judges")
        return write_stress_page(run_folders, out or run_folders[0] / "stress.html")
    if any(stressed):
        raise BenchError(
            f"{run_folders[stressed.index(True)]}: is a stress run, which no page shows beside "
            "runs of other verbs"
        )
    for folder in run_folders:
        if (folder / JOURNAL).is_file():
            raise BenchError(
                f"{folder}: is a stress run that has not ended, or of a verb without a page; "
                "the command that began it goes on from there"
            )
    saved = [load(folder) for folder in run_folders]
    for run in saved:
        if run.slim:
            raise BenchError(f"{run.folder}: is a slim run, without frames; it has no page")
    verdict = compare(load(baseline), saved[0]) if baseline is not None else None
    return write_page(saved, out or run_folders[0] / "report.html", verdict=verdict)
