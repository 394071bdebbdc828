"""Reading a saved run: its files are checked against run.json before anything uses them."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.run.run_json import read_run_json
from reports.run.schema import (
    SLIM_TABLES,
    TABLES,
    columns_since,
    schema_of,
)
from reports.run.stored_table import read_table
from reports.run.table_rules import KEY, first_broken_rule
from sim.archives import bounded_archive
from sim.dataset.files.checksums import sha256_of
from sim.files import near_paths

MAX_FILM_BYTES = 256 << 20
MAX_FILE_BYTES = 2 << 30


@dataclass(frozen=True, eq=False)
class SavedRun:
    """A saved run: meta is run.json, the data frames are its tables (`reports.run.schema`).

    A slim run has empty tables but for `SLIM_TABLES`. In a run of an earlier version, the columns
    that it lacks are NaN, or 0 where they count.
    """

    folder: Path
    meta: Mapping[str, Any]
    frames: pd.DataFrame
    episodes: pd.DataFrame
    events: pd.DataFrame
    tracking: pd.DataFrame
    detections: pd.DataFrame
    cameras: pd.DataFrame

    @property
    def name(self) -> str:
        """The run's name."""
        return str(self.meta["name"])

    @property
    def digests(self) -> dict[tuple[str, int], str]:
        """The digest of each episode, by scenario and seed."""
        return {
            (str(scenario["name"]), int(seed)): str(digest)
            for scenario in self.meta["scenarios"]
            for seed, digest in zip(scenario["seeds"], scenario["digests"], strict=True)
        }

    @property
    def version(self) -> int:
        """The version of its columns."""
        return int(self.meta["schema_version"])

    @property
    def slim(self) -> bool:
        """Whether it was saved without frames, detections, pictures and films."""
        return bool(self.meta.get("slim"))


def load(folder: Path) -> SavedRun:
    """Read a saved run.

    Raises BenchError naming the file: missing, damaged (checksum), or of another schema version.
    """
    meta = _load_meta(folder)
    for name, entry in meta["files"].items():
        _check_file(folder, name, entry)
    stored = _tables_in(meta)
    tables = {
        name: _load_table(folder / f"{name}.parquet", name, meta["schema_version"])
        if name in stored
        else schema.empty_table().to_pandas()
        for name, schema in TABLES.items()
    }
    _check_episodes(folder, meta, tables["episodes"])
    _check_keys(folder, meta, tables)
    _check_tracking(folder, tables["episodes"], tables["tracking"])
    return SavedRun(folder, meta, **tables)


def _tables_in(meta: Mapping[str, Any]) -> tuple[str, ...]:
    return SLIM_TABLES if meta.get("slim") else tuple(TABLES)


def _load_meta(folder: Path) -> dict[str, Any]:
    path = folder / "run.json"
    if folder.is_file():
        raise BenchError(f"{folder}: is a file; give the folder of a saved run.")
    if not folder.is_dir():
        hint = near_paths(folder)
        raise BenchError(f"{folder}: no such run{hint}; give the folder that `run --out` made.")
    if not path.is_file():
        raise BenchError(f"{folder}: is not a saved run: it has no run.json.")
    return read_run_json(path)


def _check_episodes(folder: Path, meta: Mapping[str, Any], episodes: pd.DataFrame) -> None:
    """Check that run.json, by which the gate pairs, and the tables list the same episodes."""
    listed = sorted((s["name"], seed) for s in meta["scenarios"] for seed in s["seeds"])
    rows = zip(episodes["scenario"], episodes["seed"], episodes["target"], strict=True)
    stored = sorted((str(name), int(seed), str(target)) for name, seed, target in rows)
    if stored != sorted((*key, target) for key in listed for target in TARGETS):
        raise BenchError(
            f"{folder / 'run.json'}: is damaged: its episodes are not those of episodes.parquet; "
            "play the run again."
        )


def _check_tracking(folder: Path, episodes: pd.DataFrame, tracking: pd.DataFrame) -> None:
    """Check that every episode with a result has its scores, of the same number of frames."""
    played = episodes[episodes["failure"] == ""].groupby(KEY)["frames"].first()
    counts = tracking.set_index(KEY)["frames"]
    if not counts.sort_index().equals(played.sort_index()):
        raise BenchError(
            f"{folder / 'tracking.parquet'}: its episodes, or their numbers of frames, are not "
            "those of episodes.parquet; play the run again."
        )


def _check_file(folder: Path, name: str, entry: Any) -> None:
    path = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise BenchError(f"{folder / 'run.json'}: lists {name!r}, which is outside the run.")
    if not path.is_file():
        raise BenchError(f"{path}: is missing; copy the run again, or play it again.")
    wanted = entry.get("sha256") if isinstance(entry, dict) else None
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise BenchError(f"{path}: is larger than {MAX_FILE_BYTES >> 30} GiB.")
        checksum = sha256_of(path)
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    if checksum != wanted:
        raise BenchError(
            f"{path}: is damaged: its checksum is not the one in run.json; copy the run again, or "
            "play it again."
        )


def _load_table(path: Path, name: str, version: int) -> pd.DataFrame:
    frame: pd.DataFrame = read_table(path, schema_of(name, version), version).to_pandas()
    broken = first_broken_rule(name, frame)
    if broken is not None:
        raise _row_fault(path, frame, *broken)
    whole = TABLES[name]
    for column in columns_since(version, name):
        counts = pa.types.is_integer(whole.field(column).type)
        frame[column] = 0 if counts else math.nan
    return frame[whole.names]


def _check_keys(folder: Path, meta: Mapping[str, Any], tables: Mapping[str, pd.DataFrame]) -> None:
    """Check that every row belongs to an episode of the run."""
    known = {(s["name"], seed) for s in meta["scenarios"] for seed in s["seeds"]}
    for name, frame in tables.items():
        odd = [key not in known for key in zip(frame["scenario"], frame["seed"], strict=True)]
        if any(odd):
            path = folder / f"{name}.parquet"
            raise _row_fault(path, frame, odd.index(True), "is of no episode of this run")


def _row_fault(path: Path, frame: pd.DataFrame, row: int, rule: str) -> BenchError:
    """The fault of a row (from 0), which is named by its number (from 1) and its episode."""
    cells = frame.iloc[row]
    target = f" {cells['target']}" if "target" in frame else ""
    return BenchError(
        f"{path}: row {row + 1} ({str(cells['scenario'])[:60]} seed {cells['seed']}{target}): "
        f"{rule}; play the run again."
    )


def read_film(run: SavedRun, file: str) -> dict[int, bytes]:
    """Read a film of a run: WebP pictures by frame. Raises BenchError where it is damaged."""
    path = run.folder / file
    try:
        with bounded_archive(path, MAX_FILM_BYTES) as film:
            return {
                int(Path(entry.filename).stem): film.read(entry)
                for entry in sorted(film.infolist(), key=lambda entry: entry.filename)
            }
    except (OSError, ValueError, RuntimeError, EOFError, zlib.error, zipfile.BadZipFile) as error:
        raise BenchError(f"{path}: is damaged: {one_line(error)}.") from error


def one_line(error: Exception) -> str:
    """Join an error's text into a single line without its full stop."""
    return " ".join(str(error).split()).rstrip(".")
