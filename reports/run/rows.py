"""Rows of a saved run: an episode as plain columns, small enough to pass between processes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np
import pyarrow as pa

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from reports.score.events import count_events, find_events
from reports.score.gospa import gospa
from reports.score.mot import ClearCounts, HotaCounts, IdentityCounts, clear_mot, hota, identity
from reports.score.records import (
    BUDGET_LEVELS,
    STAGES,
    VIEWS,
    Episode,
    EpisodeFailure,
    Picture,
    Still,
)
from reports.score.score import BANDS_M, EpisodeScore, quantile, score

Row = dict[str, object]

# Of everything that is computed here: results of different versions are not compared.
METRICS_VERSION = 1

_TEXT, _INT, _FLOAT, _BOOL = pa.string(), pa.int64(), pa.float64(), pa.bool_()
_KEY = [("scenario", _TEXT), ("seed", _INT)]
CLEAR, IDENTITY, HOTA = fields(ClearCounts), fields(IdentityCounts), fields(HotaCounts)
_GOLDEN = (5**0.5 - 1) / 2
_COVARIANCE = ("xx", "xy", "xz", "yy", "yz", "zz")

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
        *[(f"covariance_{pair}_m2", _FLOAT) for pair in _COVARIANCE],
        ("error_mm", _FLOAT),
        ("lateral_mm", _FLOAT),
        ("depth_mm", _FLOAT),
        ("surface_mm", _FLOAT),
        *[(f"error_{view}_px", _FLOAT) for view in VIEWS],
        ("err_acc_px", _FLOAT),
        *[(f"visible_{view}", _FLOAT) for view in VIEWS],
        ("nees", _FLOAT),
        ("labels", _TEXT),
    ]
)

_SUMS = ("error_mm", "lateral_mm", "abs_depth_mm", "surface_mm", "err_acc_px", "nees")
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
            for name in _SUMS
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
        ("budget_frames", _INT),
        *[(f"sum_budget_{level}_mm", _FLOAT) for level in BUDGET_LEVELS],
        ("values_json", _TEXT),
    ]
)

# One row an episode: what multi-object tracking scores are made of (`reports.score.mot`, `gospa`).
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

# What the detector found, one row a detection; in undistorted pixels. a, b: half axes; angle of
# the long one from +x towards +y.
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

# One row an episode and view: the cameras as they really were (`pjpdaf.camera.Camera`, matrices
# row by row), with which positions can be drawn into the pictures.
CAMERAS = pa.schema(
    [
        *_KEY,
        ("view", _TEXT),
        ("width_px", _INT),
        ("height_px", _INT),
        *[(name, pa.list_(_FLOAT)) for name in ("K", "R_cw", "t_cw", "distortion")],
    ]
)


@dataclass(frozen=True, eq=False)
class EpisodeRows:
    """What is kept of one episode. frames, events: columns of `FRAMES`, `EVENTS`; episodes: 3 rows.

    tracking: the row of `TRACKING`, None of an episode without a result. detections: columns of
    `DETECTIONS`; cameras: the rows of `CAMERAS`.

    stage_s: wall time summed over the frames [s], never part of the tables. truth: `motion_mark` of
    where the targets truly were.
    """

    scenario: str
    seed: int
    digest: str
    frames: Mapping[str, list[object]]
    episodes: tuple[Row, ...]
    events: tuple[Row, ...]
    pictures: tuple[Picture, ...]
    stage_s: Mapping[str, float]
    frame_count: int
    failure: str = ""
    tracking: Row | None = None
    truth: str = ""
    detections: Mapping[str, list[object]] = field(default_factory=dict)
    cameras: tuple[Row, ...] = ()
    film: tuple[Still, ...] = ()


def rows_of(played: Episode | EpisodeFailure) -> EpisodeRows:
    """Score an episode. A failure keeps three rows without frames, so that it is counted."""
    if isinstance(played, EpisodeFailure):
        return EpisodeRows(
            scenario=played.scenario,
            seed=played.seed,
            digest=played.digest,
            frames={name: [] for name in FRAMES.names},
            episodes=tuple(_failed_row(played, target) for target in TARGETS),
            events=(),
            pictures=(),
            stage_s={},
            frame_count=0,
            failure=played.reason or "unknown",
        )
    result = score(played)
    stages = sorted({*STAGES, *(name for o in played.frames for name in o.stage_s)})
    return EpisodeRows(
        scenario=played.scenario,
        seed=played.seed,
        digest=played.digest,
        frames=_frame_columns(played, result),
        episodes=_episode_rows(played, result),
        events=_event_rows(played),
        pictures=played.pictures,
        stage_s={s: sum(o.stage_s.get(s, 0.0) for o in played.frames) for s in stages},
        frame_count=len(played.frames),
        tracking=_tracking_row(played),
        truth=motion_mark(np.stack([o.truth.centres_m for o in played.frames])),
        detections=_detection_columns(played),
        cameras=_camera_rows(played),
        film=played.film,
    )


def motion_mark(centres_m: Floats) -> str:
    """Of all true centres (F, T, 3), a number a target [um]: alike where the person moved alike.

    A mean with weights that differ from number to number, so that any other motion, order or
    length shows. No digest: other processors differ in the last bits, which here stay last bits.
    """
    flat_m = np.moveaxis(centres_m, 1, 0).reshape(centres_m.shape[1], -1)
    n = flat_m.shape[1]
    weights = 2.0 * np.modf(_GOLDEN * np.arange(1, n + 1))[0] - 1.0
    marks_m = (flat_m * weights).sum(axis=1) / np.sqrt(n)
    return " ".join(str(round(1e6 * float(mark))) for mark in marks_m)


def _tracking_row(episode: Episode) -> Row:
    """Multi-object tracking counts of an episode."""
    truths = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    row: Row = {"scenario": episode.scenario, "seed": episode.seed, "frames": len(truths)}
    counted = (
        ("clear", CLEAR, clear_mot(truths, estimates)),
        ("identity", IDENTITY, identity(truths, estimates)),
    )
    for prefix, names, counts in counted:
        row |= {f"{prefix}_{f.name}": getattr(counts, f.name) for f in names}
    found = hota(truths, estimates)
    row |= {f"hota_{f.name}": getattr(found, f.name).tolist() for f in HOTA}
    parts = gospa(truths, estimates)
    row["sum_gospa_mm"] = math.fsum(1e3 * part.distance_m for part in parts)
    for name in ("localisation", "missed", "false"):
        row[f"sum_gospa_{name}_mm2"] = math.fsum(1e6 * getattr(part, name) for part in parts)
    return row


def _frame_columns(episode: Episode, result: EpisodeScore) -> dict[str, list[object]]:
    """Columns with F * T values, frame by frame, targets in order within a frame."""
    outcomes = episode.frames
    F, T = result.error_m.shape
    columns: dict[str, list[object]] = {
        "scenario": [episode.scenario] * (F * T),
        "seed": [episode.seed] * (F * T),
        "frame": [o.truth.index for o in outcomes for _ in range(T)],
        "target": list(TARGETS) * F,
        "time_s": [o.truth.time_s for o in outcomes for _ in range(T)],
        "status": [status for o in outcomes for status in o.estimates.status],
        "labels": [";".join(o.truth.events) for o in outcomes for _ in range(T)],
        "merged": list(result.merged.ravel().tolist()),
    }
    speeds = [np.linalg.norm(o.truth.velocities_mps, axis=1) for o in outcomes]
    numbers: dict[str, Floats] = {
        "truth_speed_mps": np.stack(speeds),
        "error_mm": result.error_m * 1e3,
        "lateral_mm": result.lateral_m * 1e3,
        "depth_mm": result.depth_m * 1e3,
        "surface_mm": result.surface_m * 1e3,
        "err_acc_px": result.err_acc_px,
        "nees": result.nees,
    }
    for a, axis in enumerate("xyz"):
        numbers[f"truth_{axis}_m"] = np.stack([o.truth.centres_m[:, a] for o in outcomes])
        numbers[f"surface_{axis}_m"] = np.stack([o.truth.surfaces_m[:, a] for o in outcomes])
        numbers[f"estimate_{axis}_m"] = np.stack([o.estimates.positions_m[:, a] for o in outcomes])
    for pair in _COVARIANCE:
        i, j = "xyz".index(pair[0]), "xyz".index(pair[1])
        numbers[f"covariance_{pair}_m2"] = np.stack(
            [o.estimates.covariances_m2[:, i, j] for o in outcomes]
        )
    for v, view in enumerate(VIEWS):
        numbers[f"error_{view}_px"] = result.view_px[:, :, v]
        numbers[f"visible_{view}"] = result.visible[:, :, v]
    for name, values in numbers.items():
        columns[name] = _plain(values)
    return {name: columns[name] for name in FRAMES.names}


def _detection_columns(episode: Episode) -> dict[str, list[object]]:
    """A value per detection in each column: frame by frame, view by view, in the detector's order.

    Detections are not in any order of targets: the detector does not know these.
    """
    columns: dict[str, list[object]] = {name: [] for name in DETECTIONS.names}
    for outcome in episode.frames:
        for view, seen in zip(VIEWS, outcome.detections, strict=False):
            n = len(seen)
            columns["scenario"] += [episode.scenario] * n
            columns["seed"] += [episode.seed] * n
            columns["frame"] += [outcome.truth.index] * n
            columns["view"] += [view] * n
            shape = ("x_px", "y_px", "a_px", "b_px", "angle_rad")
            for name, values in zip(shape, seen.ellipses.T, strict=True):
                columns[name] += _plain(values)
            columns["area_px"] += _plain(seen.areas_px)
    return columns


def _camera_rows(episode: Episode) -> tuple[Row, ...]:
    return tuple(
        {
            "scenario": episode.scenario,
            "seed": episode.seed,
            "view": view,
            "width_px": camera.width_px,
            "height_px": camera.height_px,
            "K": camera.K.ravel().tolist(),
            "R_cw": camera.R_cw.ravel().tolist(),
            "t_cw": camera.t_cw.tolist(),
            "distortion": camera.distortion.tolist(),
        }
        for view, camera in zip(VIEWS, episode.cameras, strict=True)
    )


def _plain(values: Floats) -> list[object]:
    """Flat list; one kind of NaN and of zero, so that bytes depend on values alone."""
    flat = np.where(np.isnan(values), np.nan, values + 0.0).ravel()
    return list(flat.tolist())


def _episode_rows(episode: Episode, result: EpisodeScore) -> tuple[Row, ...]:
    events = find_events(episode)
    rows = []
    for t, target in enumerate(TARGETS):
        counts = count_events(events, t)
        row: Row = {
            "scenario": episode.scenario,
            "seed": episode.seed,
            "target": target,
            "group": episode.group,
            "digest": episode.digest,
            "failure": "",
            "fps": float(episode.fps),
            "redrawn": episode.redrawn,
            "median_error_mm": quantile(result.error_m[:, t] * 1e3, 0.5),
            "median_err_acc_px": quantile(result.err_acc_px[:, t], 0.5),
        }
        everything = np.ones(len(episode.frames), dtype=bool)
        for prefix, chosen in (("", everything), ("merged_", result.merged[:, t])):
            row |= _sums(result, t, chosen, prefix)
        row |= {
            "ever_swapped": counts.ever_swapped,
            "ever_captured": counts.captures > 0,
            "ever_lost": counts.ever_lost,
            "swaps": counts.swaps,
            "swapped_frames": counts.swapped_frames,
            "captures": counts.captures,
            "losses": counts.losses,
            "lost_frames": counts.lost_frames,
            "recoveries": counts.recoveries,
            "sum_recovery_s": float(counts.recovery_s),
            **_budget(episode, t),
            "values_json": _json_line(episode.values),
        }
        rows.append(row)
    return tuple(rows)


def _budget(episode: Episode, t: int) -> Row:
    """Errors of a target summed over the frames in which every level of the budget has one."""
    row: Row = {"budget_frames": 0}
    for level in BUDGET_LEVELS:
        errors = episode.budget_m.get(level)
        mine = np.zeros(0) if errors is None else errors[np.isfinite(errors[:, t]), t]
        row["budget_frames"] = len(mine)
        row[f"sum_budget_{level}_mm"] = math.fsum((1e3 * mine).tolist())
    return row


def _sums(result: EpisodeScore, t: int, chosen: np.ndarray, prefix: str) -> Row:
    """Counts and sums of a target over the chosen frames (F,) bool; sums over finite values."""
    row: Row = {
        f"{prefix}frames": int(chosen.sum()),
        f"{prefix}covered": int(result.covered[chosen, t].sum()),
    }
    for bound in BANDS_M:
        inside = result.within(bound)[chosen, t]
        row[f"{prefix}within_{round(bound * 1000)}"] = int(inside.sum())
    values = {
        "error_mm": result.error_m * 1e3,
        "lateral_mm": result.lateral_m * 1e3,
        "abs_depth_mm": np.abs(result.depth_m) * 1e3,
        "surface_mm": result.surface_m * 1e3,
        "err_acc_px": result.err_acc_px,
        "nees": result.nees,
    }
    for name in _SUMS:
        mine = values[name][chosen, t]
        mine = mine[np.isfinite(mine)]
        row[f"{prefix}n_{name}"] = len(mine)
        row[f"{prefix}sum_{name}"] = math.fsum(mine.tolist())
    return row


def _failed_row(failure: EpisodeFailure, target: str) -> Row:
    zero = {"int64": 0, "double": 0.0, "string": "", "bool": False}
    row: Row = {column.name: zero[str(column.type)] for column in EPISODES}
    row |= {
        "scenario": failure.scenario,
        "seed": failure.seed,
        "target": target,
        "group": failure.group,
        "digest": failure.digest,
        "failure": failure.reason or "unknown",
        "values_json": "{}",
    }
    return row


def _event_rows(episode: Episode) -> tuple[Row, ...]:
    index = [outcome.truth.index for outcome in episode.frames]
    return tuple(
        {
            "scenario": episode.scenario,
            "seed": episode.seed,
            "kind": event.kind,
            "target": TARGETS[event.target],
            "other": TARGETS[event.other] if event.other >= 0 else "",
            "first_frame": index[event.first],
            "last_frame": index[event.last],
            "start_s": event.start_s,
            "duration_s": event.duration_s,
            "ended": event.ended,
            "blame": episode.blame.get((event.kind, event.target, event.first), ""),
        }
        for event in find_events(episode)
    )


def _json_line(values: Mapping[str, float | str]) -> str:
    return json.dumps(dict(values), sort_keys=True, ensure_ascii=False, separators=(",", ":"))
