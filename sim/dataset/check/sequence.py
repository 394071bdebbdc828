"""All checks of a sequence, and which of two files that disagree is named."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.dataset.check.cameras import check_calibration, check_rig, usable
from sim.dataset.check.events import check_events
from sim.dataset.check.exports.numbers import SequenceNumbers, numbers_of
from sim.dataset.check.fault import MISSING, Fault, FaultLog
from sim.dataset.check.files import (
    Checksums,
    FileTree,
    check_completeness,
    check_digests,
    check_repetition,
)
from sim.dataset.check.frame.checks import FrameChecks
from sim.dataset.check.frame.pixel_rays import RigRays
from sim.dataset.check.frame_tables import FrameTables, read_frames
from sim.dataset.check.projection import check_projection, check_skeleton_pixels
from sim.dataset.check.skeletons import check_skeletons
from sim.dataset.check.table_rows import check_poses, check_times
from sim.dataset.files.layout import EVENTS, OBJECTS, RECIPE, RIG, SKELETON, TRUTH
from sim.dataset.stored_sequence import StoredSequence
from sim.steps import step

NEEDED = (EVENTS, OBJECTS, RECIPE, RIG, SKELETON, TRUTH)


@dataclass(frozen=True)
class SequenceVerdict:
    """Faults of a sequence; numbers: those that exports repeat, None where a table is damaged."""

    faults: tuple[Fault, ...]
    numbers: SequenceNumbers | None


@dataclass(frozen=True, eq=False)
class _Rig:
    """Contents of rig.json that other checks rest on. names: of the instances by id."""

    frames: int
    backgrounds: int
    skew_s: float
    names: Mapping[int, str]


def check_sequence(
    sequence: StoredSequence,
    tree: FileTree,
    checksums: Checksums,
    labels: Collection[str],
    hash_files: bool,
) -> SequenceVerdict:
    """Check a sequence. tree, checksums: of its files, by paths from the data set's folder."""
    log, name = FaultLog(tree.root), sequence.name
    if hash_files:
        log.add("checksums", check_digests(tree, checksums, tree.plain))
    needed = {f"{name}/{file}" for file in NEEDED}
    log.add("files", [Fault(path, MISSING) for path in needed - tree.plain])
    log.add("files", check_repetition(tree, name, checksums))
    rig = log.read(lambda: _check_rig(sequence, log))
    if rig is None:
        return SequenceVerdict(log.all(), None)
    log.add("manifest", _manifest_faults(sequence, log.read(lambda: sequence.recipe) or {}))
    tables = log.read(lambda: read_frames(sequence))
    if tables is not None or sequence.entry.get("frames") == rig.frames:
        arrived = None if tables is None else [frame.arrived for frame in tables]
        complete = check_completeness(tree, name, rig.frames, rig.backgrounds, labels, arrived)
        log.add("files", complete)
    with np.errstate(all="ignore"):
        rays_hold = usable(sequence.rig)
        if tables is not None:
            _check_tables(sequence, tables, log)
            if rays_hold:
                faults = check_projection(name, tables, sequence.rig, rig.skew_s)
                rays_hold = not log.add("projection", faults)
            if rays_hold:
                pixels = check_skeleton_pixels(name, tables, sequence.rig, rig.skew_s)
                log.add("skeletons", pixels)
        rays = RigRays.of(sequence.rig, rig.skew_s) if rays_hold else None
        frames = FrameChecks(sequence, tree, labels, rig.names, tables, rays, log)
        last = max((_number(path) for path in tree.plain), default=0)
        for index in range(min(rig.frames, last)):
            frames.check(index)
            step()
        frames.check_backgrounds(rig.backgrounds)
    numbers = None if tables is None else numbers_of(sequence, tables)
    return SequenceVerdict(log.all(), numbers)


def _check_rig(sequence: StoredSequence, log: FaultLog) -> _Rig:
    """Check rig.json and the calibration files. Raises FileError where rig.json is damaged."""
    frames, backgrounds = sequence.frame_count, sequence.background_count
    log.add("cameras", check_rig(sequence))
    check_calibration(sequence, log)
    _ = sequence.fps  # raises where it is damaged
    names = {instance.id: instance.name for instance in sequence.instances}
    return _Rig(frames, backgrounds, sequence.skew_s, names)


def _check_tables(sequence: StoredSequence, tables: list[FrameTables], log: FaultLog) -> None:
    """Check the rows of the tables, and events.json against them."""
    log.add("times", check_times(sequence.name, tables, sequence.fps))
    log.add("poses", check_poses(sequence.name, tables))
    log.add("skeletons", check_skeletons(sequence.name, tables))
    events = log.read(lambda: sequence.events)
    if events is not None:
        log.add("events", check_events(sequence.name, tables, events))


def _manifest_faults(sequence: StoredSequence, recipe: Mapping[str, Any]) -> Iterator[Fault]:
    """Compare manifest.json's entry with rig.json and recipe.json."""
    entry, file = sequence.entry, f"{sequence.name}/{RIG}"
    values: list[tuple[str, Any, str]] = [
        ("frames", sequence.frame_count, file),
        ("fps", sequence.fps, file),
    ]
    if "digest" in recipe:
        file = f"{sequence.name}/{RECIPE}"
        values += [(key, recipe.get(key), file) for key in ("digest", "seed", "label")]
    for key, value, where in values:
        if entry and entry.get(key) != value:
            yield Fault(where, f"{key} is {value}, manifest.json says {entry.get(key)}")


def _number(path: str) -> int:
    """Number of a frame's file, 0 of any other file."""
    stem = path.rpartition("/")[2].partition(".")[0]
    return int(stem) if stem.isascii() and stem.isdigit() and len(stem) < 9 else 0
