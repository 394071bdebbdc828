"""Columns of the tables of a saved run, their units, and the versions of both."""

from __future__ import annotations

from dataclasses import fields

import pyarrow as pa

from reports.score.mot import ClearCounts, HotaCounts, IdentityCounts
from reports.score.records import (
    BUDGET_LEVELS,
    VIEWS,
)
from reports.score.score import BANDS_M

TableRow = dict[str, object]

SCHEMA_VERSION = 3
KIND = "pjpdaf-bench run"
# Version of the scores: results of different versions are not compared.
METRICS_VERSION = 1

_TEXT, _INT, _FLOAT, _BOOL = pa.string(), pa.int64(), pa.float64(), pa.bool_()
_KEY = [("scenario", _TEXT), ("seed", _INT)]
CLEAR, IDENTITY, HOTA = fields(ClearCounts), fields(IdentityCounts), fields(HotaCounts)
COVARIANCE = ("xx", "xy", "xz", "yy", "yz", "zz")

FRAMES = pa.schema(
    [
        *_KEY,
        ("frame", _INT),
        ("target", _TEXT),
        ("time_s", _FLOAT),
        ("status", _TEXT),
        ("merged", _BOOL),
        *[(f"truth_{axis}_m", _FLOAT) for axis in "xyz"],
        *[(f"surface_{axis}_m", _FLOAT) for axis in "xyz"],
        ("truth_speed_mps", _FLOAT),
        *[(f"estimate_{axis}_m", _FLOAT) for axis in "xyz"],
        *[(f"covariance_{pair}_m2", _FLOAT) for pair in COVARIANCE],
        ("error_mm", _FLOAT),
        ("lateral_mm", _FLOAT),
        ("depth_mm", _FLOAT),
        ("surface_mm", _FLOAT),
        *[(f"error_{view}_px", _FLOAT) for view in VIEWS],
        ("err_acc_px", _FLOAT),
        *[(f"visible_{view}", _FLOAT) for view in VIEWS],
        ("nees", _FLOAT),
        ("exchange_probability", _FLOAT),
        ("exchanged", _FLOAT),
        ("labels", _TEXT),
    ]
)

# Frames with a stated exchange probability and hands apart; of these the exchanged ones, and the
# sums of the stated probability and of its squared error.
EXCHANGE = [
    ("exchange_frames", _INT),
    ("exchanged_frames", _INT),
    ("sum_exchange_probability", _FLOAT),
    ("sum_exchange_brier", _FLOAT),
]

SUMS = ("error_mm", "lateral_mm", "abs_depth_mm", "surface_mm", "err_acc_px", "nees")
_COUNTED = ("frames", "covered", *[f"within_{round(b * 1000)}" for b in BANDS_M])

EPISODES = pa.schema(
    [
        *_KEY,
        ("target", _TEXT),
        ("group", _TEXT),
        ("digest", _TEXT),
        ("failure", _TEXT),
        ("fps", _FLOAT),
        ("redrawn", _INT),
        ("median_error_mm", _FLOAT),
        ("median_err_acc_px", _FLOAT),
        *[(prefix + name, _INT) for prefix in ("", "merged_") for name in _COUNTED],
        *[
            (prefix + part + name, _INT if part == "n_" else _FLOAT)
            for prefix in ("", "merged_")
            for name in SUMS
            for part in ("n_", "sum_")
        ],
        ("ever_swapped", _BOOL),
        ("ever_captured", _BOOL),
        ("ever_lost", _BOOL),
        ("swaps", _INT),
        ("swapped_frames", _INT),
        ("captures", _INT),
        ("losses", _INT),
        ("lost_frames", _INT),
        ("recoveries", _INT),
        ("sum_recovery_s", _FLOAT),
        *EXCHANGE,
        ("budget_frames", _INT),
        *[(f"sum_budget_{level}_mm", _FLOAT) for level in BUDGET_LEVELS],
        ("values_json", _TEXT),
    ]
)

# A row per episode: the counts behind multi-object tracking scores (`reports.score.mot`, `gospa`).
TRACKING = pa.schema(
    [
        *_KEY,
        ("frames", _INT),
        *[(f"clear_{f.name}", _FLOAT if f.name == "sum_distance_m" else _INT) for f in CLEAR],
        *[(f"identity_{f.name}", _INT) for f in IDENTITY],
        *[(f"hota_{f.name}", pa.list_(_FLOAT)) for f in HOTA],
        ("sum_gospa_mm", _FLOAT),
        *[(f"sum_gospa_{part}_mm2", _FLOAT) for part in ("localisation", "missed", "false")],
    ]
)

EVENTS = pa.schema(
    [
        *_KEY,
        ("kind", _TEXT),
        ("target", _TEXT),
        ("other", _TEXT),
        ("first_frame", _INT),
        ("last_frame", _INT),
        ("start_s", _FLOAT),
        ("duration_s", _FLOAT),
        ("ended", _BOOL),
        ("blame", _TEXT),
    ]
)

# A row per detection, in undistorted pixels. a, b: half axes; angle: of the long axis, from +x
# towards +y.
DETECTIONS = pa.schema(
    [
        *_KEY,
        ("frame", _INT),
        ("view", _TEXT),
        *[(f"{name}_px", _FLOAT) for name in ("x", "y", "a", "b")],
        ("angle_rad", _FLOAT),
        ("area_px", _FLOAT),
    ]
)

# A row per episode and view: the cameras as they really were (`pjpdaf.camera.Camera`, matrices
# row by row), to draw positions into the pictures.
CAMERAS = pa.schema(
    [
        *_KEY,
        ("view", _TEXT),
        ("width_px", _INT),
        ("height_px", _INT),
        *[(name, pa.list_(_FLOAT)) for name in ("K", "R_cw", "t_cw", "distortion")],
    ]
)

TABLES = {
    "frames": FRAMES,
    "episodes": EPISODES,
    "events": EVENTS,
    "tracking": TRACKING,
    "detections": DETECTIONS,
    "cameras": CAMERAS,
}
# Columns that came with a version. A run of an earlier one has them empty.
ADDED = {
    3: {
        "frames": ("exchange_probability", "exchanged"),
        "episodes": tuple(name for name, _ in EXCHANGE),
    }
}
OLDEST_VERSION = min(ADDED) - 1
# A slim run has what the gate reads, small enough for git.
SLIM_TABLES = ("episodes", "events", "tracking")


def columns_since(version: int, table: str) -> tuple[str, ...]:
    """Columns of a table that a run of this version lacks."""
    return tuple(name for v, new in ADDED.items() if v > version for name in new.get(table, ()))


def schema_of(table: str, version: int) -> pa.Schema:
    """Schema of a table in a run of this version."""
    absent = columns_since(version, table)
    return pa.schema([column for column in TABLES[table] if column.name not in absent])
