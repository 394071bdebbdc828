"""A saved run: Parquet tables and run.json, written whole or not at all, checked when read."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.run.provenance import provenance
from reports.run.rows import (
    CAMERAS,
    DETECTIONS,
    EPISODES,
    EVENTS,
    FRAMES,
    METRICS_VERSION,
    TRACKING,
    EpisodeRows,
    rows_of,
)
from reports.score.events import KINDS
from reports.score.ranking import worst_first
from reports.score.records import Episode, EpisodeFailure
from sim.files import disk_faults, part_folder, write_fault

SCHEMA_VERSION = 2
KIND = "pjpdaf-bench run"
TABLES = {
    "frames": FRAMES,
    "episodes": EPISODES,
    "events": EVENTS,
    "tracking": TRACKING,
    "detections": DETECTIONS,
    "cameras": CAMERAS,
}
# A slim run has what the gate reads, small enough for git.
SLIM_TABLES = ("episodes", "events", "tracking")
ROW_GROUP = 65536
_ASKED = ("targets", "seeds", "first_seed", "only", "settings", "preset", "detector", "tracker")


@dataclass(frozen=True)
class RunInfo:
    """What was asked for: everything in run.json that the episodes do not say themselves.

    parameters: of detector and tracker, as plain values, all of them; overrides: those changed
    from the preset. complete: every episode that was asked for is here. request: what the command
    line asked for, to be asked for again; suites: name, version and digest of each; entries: per
    scenario (its name in the results) what it is of and what is changed of it.
    """

    name: str
    preset: str = ""
    detector: str = ""
    tracker: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)
    renderer: str = ""
    argv: tuple[str, ...] = ()
    complete: bool = True
    request: Mapping[str, Any] = field(default_factory=dict)
    suites: Sequence[Mapping[str, Any]] = ()
    entries: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class SavedRun:
    """A run read back. meta: run.json; the others: its tables (`reports.run.rows`).

    Of a slim run all tables but `SLIM_TABLES` are empty.
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
    def slim(self) -> bool:
        """Whether it was saved without frames, detections, pictures and films."""
        return bool(self.meta.get("slim"))


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
    rows = [one if isinstance(one, EpisodeRows) else rows_of(one) for one in played]
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
    """Write a copy with only what the gate reads, small enough for git, and return the folder.

    No frames, detections, cameras, drawn values, times, pictures, films. Raises as `save`.
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
            table = pa.Table.from_pandas(tables[name], TABLES[name], preserve_index=False)
            write_table(part / f"{name}.parquet", table.replace_schema_metadata(), packed=True)
        none: dict[str, Any] = {"timing": [], "pictures": [], "films": []}
        meta = {**run.meta, **none, "slim": True, "files": _files_in(part)}
        text = json.dumps(meta, ensure_ascii=False) + "\n"
        (part / "run.json").write_text(text, encoding="utf-8")
    return folder


@contextmanager
def _in_place(folder: Path) -> Iterator[Path]:
    """A folder to write into; at the end it becomes `folder`, or nothing is left of it."""
    with disk_faults(folder, "the run"):
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = part_folder(folder)
        try:
            yield part
            _publish(part, folder)
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


def load(folder: Path) -> SavedRun:
    """Read a saved run.

    Raises BenchError naming the file: missing, damaged (checksum), or of another schema version.
    """
    meta = _load_meta(folder)
    for name, entry in meta["files"].items():
        _check_file(folder, name, entry)
    there = _tables_in(meta)
    tables = {
        name: _load_table(folder / f"{name}.parquet", schema)
        if name in there
        else schema.empty_table().to_pandas()
        for name, schema in TABLES.items()
    }
    _check_episodes(folder, meta, tables["episodes"])
    return SavedRun(folder, meta, **tables)


def _tables_in(meta: Mapping[str, Any]) -> tuple[str, ...]:
    return SLIM_TABLES if meta.get("slim") else tuple(TABLES)


def _write(part: Path, rows: Sequence[EpisodeRows], info: RunInfo) -> None:
    for name, table in tables_of(rows).items():
        write_table(part / f"{name}.parquet", table)
    pictures = _write_pictures(part, rows)
    films = _write_films(part, rows)
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
    return {
        path.relative_to(part).as_posix(): {
            "sha256": _sha256(path),
            "bytes": path.stat().st_size,
        }
        for path in sorted(part.rglob("*"))
        if path.is_file()
    }


def tables_of(rows: Sequence[EpisodeRows]) -> dict[str, pa.Table]:
    """The tables of a run, rows in a fixed order whatever the order of the episodes."""
    ordered = sorted(rows, key=lambda r: (r.scenario, r.seed))
    frames = pa.table(
        {name: [v for r in ordered for v in r.frames[name]] for name in FRAMES.names}, schema=FRAMES
    )
    episodes = [row for r in ordered for row in r.episodes]
    events = [row for r in ordered for row in r.events]
    tracking = [r.tracking for r in ordered if r.tracking is not None]
    cameras = [row for r in ordered for row in r.cameras]
    seen = {
        name: [v for r in ordered for v in r.detections.get(name, [])] for name in DETECTIONS.names
    }
    return {
        "frames": frames,
        "episodes": pa.Table.from_pylist(episodes, schema=EPISODES),
        "events": pa.Table.from_pylist(events, schema=EVENTS),
        "tracking": pa.Table.from_pylist(tracking, schema=TRACKING),
        "detections": pa.table(seen, schema=DETECTIONS),
        "cameras": pa.Table.from_pylist(cameras, schema=CAMERAS),
    }


def write_table(path: Path, table: pa.Table, *, packed: bool = False) -> None:
    """Parquet with every option fixed, so that equal tables are equal files.

    packed: a fifth smaller, in an encoding of numbers that some older readers lack.
    """
    numbers = [c.name for c in table.schema if pa.types.is_floating(c.type)]
    others = [name for name in table.schema.names if name not in numbers]
    pq.write_table(
        table,
        path,
        version="2.6",
        data_page_version="1.0",
        compression="zstd",
        compression_level=6,
        use_dictionary=others if packed else True,
        use_byte_stream_split=numbers if packed else False,
        write_statistics=True,
        row_group_size=ROW_GROUP,
    )


def _scenarios(
    rows: Sequence[EpisodeRows], entries: Mapping[str, Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Per scenario its seeds, with the digest of each concrete episode and what failed."""
    found: dict[str, dict[str, Any]] = {}
    for row in rows:
        entry = found.setdefault(
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
            entry["failures"].append({"seed": row.seed, "reason": row.failure})
    return list(found.values())


def _write_pictures(part: Path, rows: Sequence[EpisodeRows]) -> list[dict[str, Any]]:
    index = []
    for number, row in enumerate(rows):
        for picture in sorted(row.pictures, key=lambda p: p.frame):
            folder = f"{number:04d}_{_plain_name(row.scenario)}_{row.seed}"
            file = f"pictures/{folder}/{picture.frame:05d}.jpg"
            (part / file).parent.mkdir(parents=True, exist_ok=True)
            (part / file).write_bytes(picture.jpeg)
            index.append(
                {"scenario": row.scenario, "seed": row.seed, "frame": picture.frame, "file": file}
            )
    return index


def _write_films(part: Path, rows: Sequence[EpisodeRows]) -> list[dict[str, Any]]:
    """A ZIP of WebP frames an episode: of every scenario's first seed and of the worst ones."""
    kept = films_to_keep(rows)
    index = []
    for number, row in enumerate(rows):
        if not row.film or (row.scenario, row.seed) not in kept:
            continue
        file = f"films/{number:04d}_{_plain_name(row.scenario)}_{row.seed}.zip"
        (part / file).parent.mkdir(exist_ok=True)
        with zipfile.ZipFile(part / file, "w", zipfile.ZIP_STORED) as film:
            for still in sorted(row.film, key=lambda s: s.frame):
                # ZipInfo's own date is fixed: equal frames, equal bytes.
                film.writestr(zipfile.ZipInfo(f"{still.frame:05d}.webp"), still.webp)
        index.append(
            {
                "scenario": row.scenario,
                "seed": row.seed,
                "frames": len(row.film),
                "whole": len(row.film) == row.frame_count,
                "file": file,
            }
        )
    return index


def films_to_keep(rows: Iterable[EpisodeRows]) -> set[tuple[str, int]]:
    """(scenario, seed) of the episodes whose films are kept: every first seed and the worst.

    An episode that is not among them is not either when there are more rows.
    """
    episodes = {(row.scenario, row.seed): row.episodes for row in rows}
    first: dict[str, int] = {}
    for scenario, seed in episodes:
        first[scenario] = min(seed, first.get(scenario, seed))
    return {*first.items(), *worst_first(episodes)}


def read_film(run: SavedRun, file: str) -> dict[int, bytes]:
    """WebP pictures by frame from a film of a run. Raises BenchError where it is damaged."""
    path = run.folder / file
    try:
        with zipfile.ZipFile(path) as film:
            return {int(Path(name).stem): film.read(name) for name in sorted(film.namelist())}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise BenchError(f"{path}: is damaged: {_one_line(error)}.") from error


def _plain_name(scenario: str) -> str:
    """A scenario's name as a part of a file's name."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", scenario)[:60]


def _publish(part: Path, folder: Path) -> None:
    """Put the finished folder in place; a run that was there is moved aside first, then removed."""
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
        raise BenchError(f"{path}: is damaged: {_one_line(error)}.") from error
    if not isinstance(meta, dict) or meta.get("kind") != KIND:
        raise BenchError(f"{path}: is not the run.json of a saved run.")
    if meta.get("schema_version") != SCHEMA_VERSION:
        raise BenchError(
            f"{path}: schema version {meta.get('schema_version')!r}; "
            f"this version reads {SCHEMA_VERSION}: play the run again."
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
    for what, entries in (("picture", meta["pictures"]), ("film", meta["films"])):
        for entry in entries:
            if not isinstance(entry, dict) or entry.get("file") not in listed:
                raise BenchError(f"{path}: is damaged: a {what} is not listed among the files.")
    return meta


def _check_scenarios(path: Path, meta: Mapping[str, Any]) -> None:
    """The parts of run.json that are read by key further on."""
    for one in meta["scenarios"]:
        if not (isinstance(one, dict) and isinstance(one.get("name"), str)):
            raise BenchError(f"{path}: is damaged: a scenario has no name.")
        seeds = one.get("seeds")
        if not (isinstance(seeds, list) and all(type(seed) is int for seed in seeds)):
            raise BenchError(f"{path}: is damaged: the seeds of {one['name']} are no list.")
        for what in ("digests", "truths"):
            told = one.get(what)
            if not (isinstance(told, list) and len(told) == len(seeds)):
                raise BenchError(
                    f"{path}: is damaged: {what} of {one['name']} are not one a seed; "
                    "play the run again."
                )
    suites = meta.get("suites", [])
    if not (isinstance(suites, list) and all(_is_suite(suite) for suite in suites)):
        raise BenchError(f"{path}: is damaged: the suites have no name, version and digest.")
    request = meta.get("request", {})
    if request and not (isinstance(request, dict) and {*_ASKED} <= {*request, *meta}):
        raise BenchError(f"{path}: is damaged: 'request' does not say what was asked for.")
    if not isinstance(meta["provenance"].get("versions"), dict):
        raise BenchError(f"{path}: is damaged: 'provenance' has no versions.")


def _is_suite(suite: object) -> bool:
    return isinstance(suite, dict) and {"name", "version", "digest"} <= {*suite}


def _check_episodes(folder: Path, meta: Mapping[str, Any], episodes: pd.DataFrame) -> None:
    """The gate pairs by run.json and reads the tables: both must have the same episodes."""
    told = sorted((one["name"], seed) for one in meta["scenarios"] for seed in one["seeds"])
    rows = zip(episodes["scenario"], episodes["seed"], episodes["target"], strict=True)
    there = sorted((str(name), int(seed), str(target)) for name, seed, target in rows)
    if there != sorted((*key, target) for key in told for target in TARGETS):
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
        found = _sha256(path)
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    if found != wanted:
        raise BenchError(
            f"{path}: is damaged: its checksum is not the one in run.json; copy the run again, or "
            "play it again."
        )


def _load_table(path: Path, schema: pa.Schema) -> pd.DataFrame:
    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise BenchError(f"{path}: is damaged: {_one_line(error)}.") from error
    if not table.schema.equals(schema):
        odd = sorted({*schema.names} ^ {*table.schema.names}) or ["types"]
        raise BenchError(
            f"{path}: has other columns than schema {SCHEMA_VERSION}: {', '.join(odd)}."
        )
    frame: pd.DataFrame = table.to_pandas()
    known = {"target": {*TARGETS}, "kind": {*KINDS}}
    for column, words in known.items():
        if column in frame and not set(frame[column]) <= words:
            raise BenchError(f"{path}: column {column!r} has unknown values.")
    return frame


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()).rstrip(".")
