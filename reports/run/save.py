"""Saving a run: Parquet tables, pictures, films and run.json, written whole or not at all."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pyarrow as pa

from pjpdaf.errors import BenchError
from reports.run.films import plain_name, write_films
from reports.run.load import SavedRun
from reports.run.provenance import provenance
from reports.run.rows import EpisodeRows, rows_of
from reports.run.schema import (
    KIND,
    METRICS_VERSION,
    SCHEMA_VERSION,
    SLIM_TABLES,
    schema_of,
)
from reports.run.tables import tables_of, write_table
from reports.score.records import Episode, EpisodeFailure
from sim.dataset.files.checksums import sha256_of
from sim.files import disk_faults, part_folder, write_fault


@dataclass(frozen=True)
class RunInfo:
    """The request behind a run: everything in run.json that its episodes do not hold.

    lag_frames: how much later than their frame the estimates came; parameters: all of detector and
    tracker, as plain values; overrides: those changed from the
    preset. complete: every episode of the request is here. request: the words of the command line,
    to play it again; suites: name, version and digest of each; entries: by a scenario's name in
    the results, its origin and its changed values.
    """

    name: str
    preset: str = ""
    detector: str = ""
    tracker: str = ""
    lag_frames: int = 0
    parameters: Mapping[str, Any] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)
    renderer: str = ""
    argv: tuple[str, ...] = ()
    complete: bool = True
    request: Mapping[str, Any] = field(default_factory=dict)
    suites: Sequence[Mapping[str, Any]] = ()
    entries: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def save(
    folder: Path,
    played: Iterable[Episode | EpisodeFailure | EpisodeRows],
    info: RunInfo,
    *,
    force: bool = False,
) -> Path:
    """Write a run into `folder` and return it.

    `played` may come in any order: frames, episodes and events.parquet have the same bytes for the
    same episodes. An existing folder must be empty, or with `force` a run, which is replaced.
    Raises BenchError where the folder is taken, cannot be written, or an episode comes twice,
    InfrastructureError where the disk is full.
    """
    folder = Path(os.path.abspath(folder))  # noqa: PTH100 - keeps a link that is the folder's parent
    check_free(folder, force=force)
    rows = [item if isinstance(item, EpisodeRows) else rows_of(item) for item in played]
    rows.sort(key=lambda r: (r.scenario, r.seed))
    for a, b in itertools.pairwise(rows):
        if (a.scenario, a.seed) == (b.scenario, b.seed):
            raise BenchError(
                f"Scenario {a.scenario!r} seed {a.seed} was given twice; a run has it once."
            )
    with _in_place(folder) as part:
        _write(part, rows, info)
    return folder


def save_slim(run: SavedRun, folder: Path, *, force: bool = False) -> Path:
    """Write a copy with only the gate's tables, small enough for git, and return the folder.

    No frames, detections, cameras, drawn values, times, pictures, films. It keeps the version of
    the run. Raises as `save`.
    """
    folder = Path(os.path.abspath(folder))  # noqa: PTH100 - as in save
    check_free(folder, force=force)
    if not run.slim and folder.exists() and folder.samefile(run.folder):
        raise BenchError(f"{folder}: is the whole run itself; give another folder for its copy.")
    # The digests are in run.json, and the drawn values follow from them.
    episodes = run.episodes.assign(digest="", values_json="{}")
    tables = {"episodes": episodes, "events": run.events, "tracking": run.tracking}
    with _in_place(folder) as part:
        for name in SLIM_TABLES:
            schema = schema_of(name, run.version)
            table = pa.Table.from_pandas(tables[name], schema, preserve_index=False)
            write_table(part / f"{name}.parquet", table.replace_schema_metadata(), packed=True)
        empty: dict[str, Any] = {"timing": [], "pictures": [], "films": []}
        meta = {**run.meta, **empty, "slim": True, "files": _files_in(part)}
        text = json.dumps(meta, ensure_ascii=False) + "\n"
        (part / "run.json").write_text(text, encoding="utf-8")
    return folder


@contextmanager
def _in_place(folder: Path) -> Iterator[Path]:
    """Yield a folder to write into, which becomes `folder` at the end, or vanishes on an error."""
    with disk_faults(folder, "the run"):
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = part_folder(folder)
        try:
            yield part
            publish(part, folder)
        finally:
            shutil.rmtree(part, ignore_errors=True)


def check_free(folder: Path, *, force: bool = False) -> None:
    """Raise BenchError unless a run can be saved into `folder`; call it before hours of work."""
    try:
        if not folder.exists():
            parent = next(p for p in [*folder.absolute().parents] if p.exists())
            if not (parent.is_dir() and os.access(parent, os.W_OK | os.X_OK)):
                raise BenchError(f"{folder}: cannot write the run: {parent} is not writable.")
            return
        if not folder.is_dir():
            raise BenchError(f"{folder}: is a file; give a new folder for the run.")
        if not os.access(folder.absolute().parent, os.W_OK | os.X_OK):
            raise BenchError(f"{folder}: cannot write the run: {folder.parent} is not writable.")
        if not any(folder.iterdir()):
            return
        if not force:
            raise BenchError(f"{folder}: exists and is not empty; give another folder.")
        if not (folder / "run.json").is_file():
            raise BenchError(f"{folder}: is not a saved run, so it is not replaced.")
    except OSError as error:
        raise write_fault(folder, "the run", error) from error


def _write(part: Path, rows: Sequence[EpisodeRows], info: RunInfo) -> None:
    for name, table in tables_of(rows).items():
        write_table(part / f"{name}.parquet", table)
    pictures = _write_pictures(part, rows)
    films = write_films(part, rows)
    meta = {
        "kind": KIND,
        "schema_version": SCHEMA_VERSION,
        "metrics_version": METRICS_VERSION,
        "name": info.name,
        "complete": info.complete,
        "slim": False,
        "preset": info.preset,
        "detector": info.detector,
        "tracker": info.tracker,
        "lag_frames": info.lag_frames,
        "parameters": dict(info.parameters),
        "overrides": dict(info.overrides),
        "request": dict(info.request),
        "suites": [dict(suite) for suite in info.suites],
        "scenarios": _scenarios(rows, info.entries),
        "provenance": provenance(info.argv, info.renderer),
        "pictures": pictures,
        "films": films,
        "timing": [
            {
                "scenario": r.scenario,
                "seed": r.seed,
                "frames": r.frame_count,
                "stage_s": dict(r.stage_s),
            }
            for r in rows
            if not r.failure
        ],
        "files": _files_in(part),
    }
    text = json.dumps(meta, indent=1, ensure_ascii=False, default=str) + "\n"
    # run.json last: a folder without it is no run.
    (part / "run.json").write_text(text, encoding="utf-8")


def _files_in(part: Path) -> dict[str, dict[str, Any]]:
    """Checksum and size of each file by its path in the folder."""
    return {
        path.relative_to(part).as_posix(): {
            "sha256": sha256_of(path),
            "bytes": path.stat().st_size,
        }
        for path in sorted(part.rglob("*"))
        if path.is_file()
    }


def _scenarios(
    rows: Sequence[EpisodeRows], entries: Mapping[str, Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Per scenario its seeds, the digest and motion of each episode, and its failures."""
    scenarios: dict[str, dict[str, Any]] = {}
    for row in rows:
        entry = scenarios.setdefault(
            row.scenario,
            {
                "name": row.scenario,
                "group": row.episodes[0]["group"],
                **entries.get(row.scenario, {}),
                "seeds": [],
                "digests": [],
                "truths": [],
                "failures": [],
            },
        )
        entry["seeds"].append(row.seed)
        entry["digests"].append(row.digest)
        entry["truths"].append(row.truth)
        if row.failure:
            entry["failures"].append(
                {"seed": row.seed, "reason": row.failure, "kind": row.failure_kind}
            )
    return list(scenarios.values())


def _write_pictures(part: Path, rows: Sequence[EpisodeRows]) -> list[dict[str, Any]]:
    index = []
    for number, row in enumerate(rows):
        for picture in sorted(row.pictures, key=lambda p: p.frame):
            folder = f"{number:04d}_{plain_name(row.scenario)}_{row.seed}"
            file = f"pictures/{folder}/{picture.frame:05d}.jpg"
            (part / file).parent.mkdir(parents=True, exist_ok=True)
            (part / file).write_bytes(picture.jpeg)
            index.append(
                {"scenario": row.scenario, "seed": row.seed, "frame": picture.frame, "file": file}
            )
    return index


def publish(part: Path, folder: Path) -> None:
    """Rename a whole run to its place on the same disk. Raises OSError.

    A run that was there is moved aside first, then removed.
    """
    part.chmod(0o755)
    if not folder.exists():
        part.rename(folder)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{folder.name}.old-", dir=folder.parent))
    try:
        folder.rename(old / "run")
        try:
            part.rename(folder)
        except OSError:
            (old / "run").rename(folder)
            raise
    finally:
        shutil.rmtree(old, ignore_errors=True)
