"""Files of recorded motion: NPZ and CSV (and BVH, by `sim.clips.bvh`) become clips.

Readers accept the formats described here and in docs/recorded_motion.md; any other file raises a
BenchError whose line names the rule and the place.
"""

from __future__ import annotations

import csv
import math
import zipfile
import zlib
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from pjpdaf.errors import BenchError
from sim.archives import bounded_archive
from sim.clips.bvh import clip_of_bvh
from sim.clips.clips import HANDS, JOINTS, Clip, clip_of

SUFFIXES = (".npz", ".csv", ".bvh")
MAX_BYTES = 64 << 20
MAX_UNPACKED = 256 << 20  # of an NPZ: it may be compressed
MAX_FRAMES = 500_000
MAX_COLUMNS = 10_000

# The short names of joints: NPZ files, and the CSV files that go with them.
SHORT = {
    "head": "head",
    **{
        f"{side[0]}{short}": f"{side}_{joint}"
        for side in ("left", "right")
        for short, joint in (
            ("sho", "shoulder"),
            ("elb", "elbow"),
            ("wri", "wrist"),
            ("hand", "hand"),
        )
    },
}


def load_clip(
    path: Path | str,
    judged_s: tuple[float, float] | None = None,
    unit_m: float | None = None,
) -> Clip:
    """The clip of an .npz, .csv or .bvh file. Raises BenchError with file and place of a fault.

    judged_s: as of `clip_of`; unit_m: of a BVH file's lengths, None = guessed.
    """
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in SUFFIXES:
        raise BenchError(f"{path}: a clip must end in {', '.join(SUFFIXES)}")
    try:
        if not file.exists():
            raise BenchError(f"{path}: no such file")
        if not file.is_file():
            raise BenchError(f"{path}: is not a file")
        state = file.stat()
        if state.st_size > MAX_BYTES:
            raise BenchError(f"{path}: is larger than {MAX_BYTES >> 20} MiB")
        return _load(str(path), suffix, state.st_size, state.st_mtime_ns, judged_s, unit_m)
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise BenchError(f"{path}: cannot be read: {reason}") from None


@lru_cache(maxsize=4)  # an episode reads its clip several times
def _load(
    path: str,
    suffix: str,
    size: int,
    mtime_ns: int,
    judged_s: tuple[float, float] | None,
    unit_m: float | None,
) -> Clip:
    if suffix == ".npz":
        return _clip_of_npz(path, judged_s)
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise BenchError(f"{path}: is not UTF-8 text (byte {fault.start})") from None
    if suffix == ".csv":
        return clip_of_csv(text, path, judged_s)
    return clip_of_bvh(text, path, unit_m, judged_s)


# --- NPZ -----------------------------------------------------------------------------------------


def _clip_of_npz(path: str, judged_s: tuple[float, float] | None = None) -> Clip:
    """`t` (n,) [s]; `joints` (k,) short names; `xyz` (n, k, 3) [m], NaN = not recorded."""
    arrays = _arrays(path, ("t", "joints", "xyz"))
    times, names, xyz = arrays["t"], arrays["joints"], arrays["xyz"]
    if names.dtype.kind != "U" or names.ndim != 1:
        raise BenchError(f"{path}: joints must be a list of names, got {_shortened(names)}")
    for name, array in (("t", times), ("xyz", xyz)):
        if array.dtype.kind not in "fiu":
            raise BenchError(f"{path}: {name} must hold numbers, got {_shortened(array)}")
    joints = tuple(str(name) for name in names)
    want = (len(times) if times.ndim else 0, len(joints), 3)
    if times.ndim != 1 or xyz.shape != want:
        raise BenchError(
            f"{path}: t must be (frames,) and xyz (frames, {len(joints)} joints, 3), "
            f"got {times.shape} and {xyz.shape}"
        )
    _check_frames(path, len(times))
    for joint in joints:
        if joint not in SHORT:
            raise BenchError(f"{path}: joints: {joint[:40]!r} is none of {', '.join(SHORT)}")
        if joints.count(joint) > 1:
            raise BenchError(f"{path}: joints: {joint!r} is there twice")
    return clip_of(
        path,
        times.astype(np.float64),
        tuple(SHORT[j] for j in joints),
        xyz.astype(np.float64),
        judged_s=judged_s,
    )


def _arrays(path: str, names: Sequence[str]) -> dict[str, np.ndarray]:
    try:
        bounded_archive(Path(path), MAX_UNPACKED).close()
        with np.load(path, allow_pickle=False) as saved:
            missing = [name for name in names if name not in saved.files]
            if missing:
                there = ", ".join(saved.files)[:200] or "nothing"
                raise BenchError(f"{path}: has no array {', '.join(missing)}; it has: {there}")
            return {name: np.asarray(saved[name]) for name in names}
    except zipfile.BadZipFile as fault:
        if str(fault).startswith(("is ", "has ")):
            raise BenchError(f"{path}: {fault}") from None
        raise BenchError(f"{path}: is damaged, or not an NPZ (zip) file") from None
    except ValueError as fault:
        if "pickle" in str(fault).lower():
            raise BenchError(
                f"{path}: holds pickled Python objects, which could run code and are not read; "
                "save plain arrays"
            ) from None
        raise BenchError(f"{path}: is damaged: {_line(fault)}") from None
    except (
        EOFError,
        KeyError,
        MemoryError,
        NotImplementedError,
        RuntimeError,
        zlib.error,
    ) as fault:
        raise BenchError(f"{path}: is damaged: {_line(fault)}") from None


def _shortened(array: np.ndarray) -> str:
    return f"{array.dtype} {array.shape}"


def _line(fault: Exception) -> str:
    return (str(fault).splitlines() or [type(fault).__name__])[0][:160]


# --- CSV -----------------------------------------------------------------------------------------


def clip_of_csv(text: str, path: str, judged_s: tuple[float, float] | None = None) -> Clip:
    """Columns `t` or `time_s` [s], then x, y, z [m] of joints: `lhand_x` or `left_hand_x`.

    Lines before the header that begin with # are comments; an empty cell or nan = not recorded;
    other columns are not read. `path` names it in faults.
    """
    lines = text.splitlines()
    top = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    rows = csv.reader(lines[top:], strict=True)
    try:
        header = [cell.strip() for cell in next(rows, [])]
        time_at, places = _columns(header, f"{path}:{top + 1}")
        joints = tuple(places)
        wanted = [time_at, *(column for triple in places.values() for column in triple)]
        numbers: list[list[float]] = []
        for row in rows:
            if not row:
                continue  # an empty line
            line = top + rows.line_num
            if len(row) != len(header):
                raise BenchError(f"{path}:{line}: has {len(row)} cells, the header {len(header)}")
            numbers.append([_cell(row[at], path, line, header[at]) for at in wanted])
            _check_frames(path, len(numbers))
    except csv.Error as fault:
        raise BenchError(f"{path}:{top + rows.line_num}: is not CSV: {fault}") from None
    table = np.array(numbers, dtype=np.float64).reshape(len(numbers), len(wanted))
    xyz = table[:, 1:].reshape(len(table), len(joints), 3)
    return clip_of(path, table[:, 0], joints, xyz, judged_s=judged_s)


def _columns(header: list[str], where: str) -> tuple[int, dict[str, tuple[int, int, int]]]:
    """Where the time is, and the x, y, z of each joint that has columns."""
    if len(header) > MAX_COLUMNS:
        raise BenchError(f"{where}: has more than {MAX_COLUMNS} columns")
    counts = Counter(header)
    for name in header:
        if name and counts[name] > 1:
            raise BenchError(f"{where}: column {name[:40]} is there twice")
    short = "t" in header and "time_s" not in header
    names = SHORT if short else {joint: joint for joint in JOINTS}
    needed = ["t" if short else "time_s"]
    needed += [f"{n}_{a}" for n, j in names.items() if j in ("head", *HANDS) for a in "xyz"]
    # Of any other joint all three or none.
    needed += [
        f"{n}_{a}"
        for n in names
        if any(f"{n}_{a}" in header for a in "xyz")
        for a in "xyz"
        if f"{n}_{a}" not in needed
    ]
    missing = [name for name in needed if name not in header]
    if missing:
        listed = ", ".join(missing[:9]) + (" ..." if len(missing) > 9 else "")
        raise BenchError(f"{where}: columns are missing: {listed}")
    places = {
        joint: (header.index(f"{n}_x"), header.index(f"{n}_y"), header.index(f"{n}_z"))
        for n, joint in names.items()
        if f"{n}_x" in header
    }
    return header.index(needed[0]), places


def _cell(text: str, path: str, line: int, column: str) -> float:
    text = text.strip()
    if not text:
        return math.nan
    try:
        if "_" in text:
            raise ValueError
        return float(text)
    except ValueError:
        raise BenchError(f"{path}:{line}: {column}: must be a number, got {text[:40]!r}") from None


def _check_frames(path: str, frames: int) -> None:
    if frames > MAX_FRAMES:
        raise BenchError(f"{path}: has more than {MAX_FRAMES} frames")
