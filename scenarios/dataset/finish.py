"""Files of a data set beside its sequences: exports, common calibration, card, checksums."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError
from reports.dataset.card import write_card
from scenarios.console.interrupts import Interrupted, interrupts
from scenarios.console.progress import Meter, progress
from scenarios.dataset.folder import only_process
from scenarios.dataset.rays import compare_with_rays
from sim.dataset.croissant import CROISSANT, croissant_record
from sim.dataset.export.registry import EXPORTS
from sim.dataset.files.checksums import files_below, read_sums, sha256_of, text_of
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import CALIBRATION, CHECKSUMS, CONVENTIONS, PART
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.raytruth import RayFigures
from sim.dataset.reader import Dataset, open_dataset
from sim.dataset.splits import SPLITS, splits_record
from sim.dataset.statistics import statistics_of
from sim.files import disk_faults, part_folder, written_whole_file
from sim.processes import WorkerPool

RAY_FRAMES = 4  # of a data set, compared with rays for its card


def check_libraries(exports: Sequence[str]) -> None:
    """Raise BenchError, before hours of work, where the library of a format is not installed."""
    for name in exports:
        EXPORTS[name].check_library()


def write_exports(dataset: Dataset, exports: Sequence[str], jobs: int, meter: Meter) -> list[Path]:
    """Write the data set in other formats; returns the files. jobs: worker processes.

    Raises BenchError.
    """
    frames = {s.name: replace(s).frame_count for s in dataset.sequences}
    files = []
    with WorkerPool(jobs) as pool:
        meter.running = pool.running_steps
        for name in exports:
            meter.begin(f"export {name}", sum(frames.values()))
            files += EXPORTS[name](
                dataset,
                dataset.folder,
                on_sequence=lambda sequence: meter.finish(frames[sequence]),
                pool=pool if jobs > 1 else None,
            )
    return files


def write_calibration(dataset: Dataset) -> None:
    """Write the common `calib/`; none where the sequences have different calibrations."""
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
    """Write conventions, common calibration, splits, Croissant record and card.

    argv: the command that made the data set; rays: its comparison with rays. Raises BenchError.
    """
    write_text(dataset.folder / CONVENTIONS, json.dumps(conventions(), indent=1) + "\n")
    write_calibration(dataset)
    record = splits_record(dataset.sequences)
    write_text(dataset.folder / SPLITS, json.dumps(record, indent=1) + "\n")
    write_text(dataset.folder / CROISSANT, json.dumps(croissant_record(dataset), indent=1) + "\n")
    write_card(dataset, statistics_of(dataset), rays, command=argv)


def write_text(path: Path, text: str) -> None:
    """Write or replace a file, whole or not at all. Raises BenchError of the disk."""
    with written_whole_file(path, "the data set", replace=True) as part:
        part.write_text(text, encoding="utf-8")


def finish_dataset(
    out: Path,
    entries: Sequence[SequenceEntry],
    settings: Mapping[str, Any],
    made_with: Mapping[str, Any],
    exports: Sequence[str],
    command: Sequence[str],
    jobs: int,
    meter: Meter,
) -> None:
    """Write everything that is made from the finished sequences.

    jobs: worker processes of the exports. A few frames are compared with rays, and the card shows
    the result. The manifest becomes complete, and is summed, last.
    """
    write_manifest(out, manifest_record(entries, settings, made_with, False, command))
    dataset = open_dataset(out)
    write_exports(dataset, exports, jobs, meter)
    _write_listing(dataset, command, meter)
    write_manifest(out, manifest_record(entries, settings, made_with, True, command))
    write_checksums(out, [entry.folder for entry in entries])


def export_dataset(folder: Path, exports: Sequence[str], jobs: int) -> list[Path]:
    """Write the formats, card, Croissant record and checksums of a finished data set anew.

    jobs: worker processes of the formats. Returns the files of the formats. Raises BenchError, also
    where the data set is not finished; Interrupted after a signal.
    """
    check_libraries(exports)
    dataset = open_dataset(folder)
    if not dataset.manifest.get("complete"):
        raise BenchError(f"{folder}: is not finished; give the command that made it once more")
    with only_process(folder), interrupts() as arrived:
        try:
            with arrived.raising(), progress() as meter:
                return _write_formats(dataset, exports, jobs, meter)
        except KeyboardInterrupt:
            raise Interrupted(
                f"interrupted: not all formats of {folder} are written, nor their checksums; the "
                "same command writes them anew"
            ) from None


def _write_formats(dataset: Dataset, exports: Sequence[str], jobs: int, meter: Meter) -> list[Path]:
    """Write formats, and what lists them: card, Croissant record, checksums."""
    written = write_exports(dataset, exports, jobs, meter)
    command = dataset.manifest.get("command")
    argv = [str(word) for word in command] if isinstance(command, list) else []
    _write_listing(dataset, argv, meter)
    write_checksums(dataset.folder, [sequence.name for sequence in dataset.sequences])
    return written


def _write_listing(dataset: Dataset, command: Sequence[str], meter: Meter) -> None:
    """Write what lists a data set's contents, with the figures of a few frames against rays."""
    meter.begin("comparing with rays", RAY_FRAMES)
    figures = compare_with_rays(dataset.folder, RAY_FRAMES).figures
    meter.begin("statistics and checksums", None)
    write_top(dataset, command, figures)


def write_checksums(out: Path, sequences: Sequence[str]) -> None:
    """Write SHA256SUMS: sequences' own sums are taken over, all other files are read."""
    sums: dict[str, str] = {}
    for name in sequences:
        own = out / name / CHECKSUMS
        sums |= {f"{name}/{path}": value for path, value in read_sums(own).items()}
        sums[f"{name}/{CHECKSUMS}"] = sha256_of(own)
    known = set(sequences)
    for path in sorted(out.iterdir()):
        if path.name in known or path.name == CHECKSUMS or path.name.startswith(PART):
            continue
        for file in files_below(path) if path.is_dir() else (path,):
            sums[file.relative_to(out).as_posix()] = sha256_of(file)
    write_text(out / CHECKSUMS, text_of(sums))
