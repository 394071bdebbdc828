"""Reading a saved run: its files are checked against run.json before anything uses them."""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.run.schema import (
    KIND,
    OLDEST_VERSION,
    SCHEMA_VERSION,
    SLIM_TABLES,
    TABLES,
    columns_since,
    schema_of,
)
from reports.score.events import KINDS
from sim.dataset.files.checksums import sha256_of

_REQUEST = ("targets", "seeds", "first_seed", "only", "settings", "preset", "detector", "tracker")


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
    return SavedRun(folder, meta, **tables)


def _tables_in(meta: Mapping[str, Any]) -> tuple[str, ...]:
    return SLIM_TABLES if meta.get("slim") else tuple(TABLES)


def _load_meta(folder: Path) -> dict[str, Any]:
    path = folder / "run.json"
    if folder.is_file():
        raise BenchError(f"{folder}: is a file; give the folder of a saved run.")
    if not folder.is_dir():
        raise BenchError(f"{folder}: no such run; give the folder that `run --out` made.")
    if not path.is_file():
        raise BenchError(f"{folder}: is not a saved run: it has no run.json.")
    try:
        meta = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BenchError(f"{path}: is damaged: {one_line(error)}.") from error
    if not isinstance(meta, dict) or meta.get("kind") != KIND:
        raise BenchError(f"{path}: is not the run.json of a saved run.")
    version = meta.get("schema_version")
    if type(version) is not int or not OLDEST_VERSION <= version <= SCHEMA_VERSION:
        raise BenchError(
            f"{path}: schema version {version!r}; this version reads {OLDEST_VERSION} to "
            f"{SCHEMA_VERSION}: play the run again."
        )
    shapes = {"name": str, "files": dict, "scenarios": list, "pictures": list, "timing": list}
    shapes |= {"films": list, "provenance": dict}
    for name, kind in {**shapes, "complete": bool}.items():
        if not isinstance(meta.get(name), kind):
            raise BenchError(f"{path}: is damaged: {name!r} is missing or not a {kind.__name__}.")
    listed = set(meta["files"])
    for needed in [f"{name}.parquet" for name in _tables_in(meta)]:
        if needed not in listed:
            raise BenchError(f"{path}: is damaged: {needed} is not listed.")
    _check_scenarios(path, meta)
    for noun, entries in (("picture", meta["pictures"]), ("film", meta["films"])):
        for entry in entries:
            if not isinstance(entry, dict) or entry.get("file") not in listed:
                raise BenchError(f"{path}: is damaged: a {noun} is not listed among the files.")
    return meta


def _check_scenarios(path: Path, meta: Mapping[str, Any]) -> None:
    """Check the fields of run.json that other modules read by key."""
    for scenario in meta["scenarios"]:
        if not (isinstance(scenario, dict) and isinstance(scenario.get("name"), str)):
            raise BenchError(f"{path}: is damaged: a scenario has no name.")
        name, seeds = scenario["name"], scenario.get("seeds")
        if not (isinstance(seeds, list) and all(type(seed) is int for seed in seeds)):
            raise BenchError(f"{path}: is damaged: the seeds of {name} are no list.")
        for key in ("digests", "truths"):
            values = scenario.get(key)
            if not (isinstance(values, list) and len(values) == len(seeds)):
                raise BenchError(
                    f"{path}: is damaged: {key} of {name} do not match its seeds; "
                    "play the run again."
                )
    suites = meta.get("suites", [])
    if not (isinstance(suites, list) and all(_is_suite(suite) for suite in suites)):
        raise BenchError(f"{path}: is damaged: the suites have no name, version and digest.")
    request = meta.get("request", {})
    if request and not (isinstance(request, dict) and {*_REQUEST} <= {*request, *meta}):
        raise BenchError(f"{path}: is damaged: 'request' is not complete.")
    if not isinstance(meta["provenance"].get("versions"), dict):
        raise BenchError(f"{path}: is damaged: 'provenance' has no versions.")


def _is_suite(suite: object) -> bool:
    return isinstance(suite, dict) and {"name", "version", "digest"} <= {*suite}


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


def _check_file(folder: Path, name: str, entry: Any) -> None:
    path = folder / name
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise BenchError(f"{folder / 'run.json'}: lists {name!r}, which is outside the run.")
    if not path.is_file():
        raise BenchError(f"{path}: is missing; copy the run again, or play it again.")
    wanted = entry.get("sha256") if isinstance(entry, dict) else None
    try:
        checksum = sha256_of(path)
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    if checksum != wanted:
        raise BenchError(
            f"{path}: is damaged: its checksum is not the one in run.json; copy the run again, or "
            "play it again."
        )


def _load_table(path: Path, name: str, version: int) -> pd.DataFrame:
    schema = schema_of(name, version)
    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise BenchError(f"{path}: is damaged: {one_line(error)}.") from error
    if not table.schema.equals(schema):
        odd = sorted({*schema.names} ^ {*table.schema.names}) or ["types"]
        raise BenchError(f"{path}: has other columns than schema {version}: {', '.join(odd)}.")
    frame: pd.DataFrame = table.to_pandas()
    whole = TABLES[name]
    for column in columns_since(version, name):
        counts = pa.types.is_integer(whole.field(column).type)
        frame[column] = 0 if counts else math.nan
    frame = frame[whole.names]
    known = {"target": {*TARGETS}, "kind": {*KINDS}}
    for column, values in known.items():
        if column in frame and not set(frame[column]) <= values:
            raise BenchError(f"{path}: column {column!r} has unknown values.")
    return frame


def read_film(run: SavedRun, file: str) -> dict[int, bytes]:
    """Read a film of a run: WebP pictures by frame. Raises BenchError where it is damaged."""
    path = run.folder / file
    try:
        with zipfile.ZipFile(path) as film:
            return {int(Path(name).stem): film.read(name) for name in sorted(film.namelist())}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise BenchError(f"{path}: is damaged: {one_line(error)}.") from error


def one_line(error: Exception) -> str:
    """Join an error's text into a single line without its full stop."""
    return " ".join(str(error).split()).rstrip(".")
