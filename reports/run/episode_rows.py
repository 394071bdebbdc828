"""Rows of an episode: counts and sums a target, tracking scores, events, cameras."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping

import numpy as np

from pjpdaf.targets import HANDS, TARGETS
from reports.run.schema import CLEAR, EPISODES, HOTA, IDENTITY, SUMS, TableRow
from reports.score.events import count_events, find_events
from reports.score.exchange import exchange_of
from reports.score.gospa import gospa
from reports.score.mot import clear_mot, hota, identity
from reports.score.records import (
    BUDGET_LEVELS,
    VIEWS,
    Episode,
    EpisodeFailure,
)
from reports.score.score import BANDS_M, EpisodeScore, quantile


def tracking_row(episode: Episode) -> TableRow:
    """The row of `TRACKING` of an episode: counts of multi-object tracking and sums of GOSPA."""
    truths = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    row: TableRow = {"scenario": episode.scenario, "seed": episode.seed, "frames": len(truths)}
    counted = (
        ("clear", CLEAR, clear_mot(truths, estimates)),
        ("identity", IDENTITY, identity(truths, estimates)),
    )
    for prefix, names, counts in counted:
        row |= {f"{prefix}_{f.name}": getattr(counts, f.name) for f in names}
    hota_counts = hota(truths, estimates)
    row |= {f"hota_{f.name}": getattr(hota_counts, f.name).tolist() for f in HOTA}
    parts = gospa(truths, estimates)
    row["sum_gospa_mm"] = math.fsum(1e3 * part.distance_m for part in parts)
    for name in ("localisation", "missed", "false"):
        row[f"sum_gospa_{name}_mm2"] = math.fsum(1e6 * getattr(part, name) for part in parts)
    return row


def camera_rows(episode: Episode) -> tuple[TableRow, ...]:
    """The rows of `CAMERAS` of an episode, a view each."""
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


def episode_rows(episode: Episode, result: EpisodeScore) -> tuple[TableRow, ...]:
    """The rows of `EPISODES` of an episode, a target each."""
    events = find_events(episode)
    rows = []
    for t, target in enumerate(TARGETS):
        counts = count_events(events, t)
        row: TableRow = {
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
            **_exchange(episode, t),
            **_budget(episode, t),
            "values_json": _json_line(episode.values),
        }
        rows.append(row)
    return tuple(rows)


def _exchange(episode: Episode, t: int) -> TableRow:
    """Count and sum the frames with a stated exchange probability; none for the head."""
    judged = exchange_of(episode).judged
    stated, exchanged = judged.stated, judged.exchanged
    if t not in HANDS:
        stated = exchanged = np.zeros(0)
    return {
        "exchange_frames": len(stated),
        "exchanged_frames": int(exchanged.sum()),
        "sum_exchange_probability": math.fsum(stated.tolist()),
        "sum_exchange_brier": math.fsum(((stated - exchanged) ** 2).tolist()),
    }


def _budget(episode: Episode, t: int) -> TableRow:
    """Sum a target's errors over the frames in which every level of the budget has an error."""
    row: TableRow = {"budget_frames": 0}
    for level in BUDGET_LEVELS:
        errors = episode.budget_m.get(level)
        mine = np.zeros(0) if errors is None else errors[np.isfinite(errors[:, t]), t]
        row["budget_frames"] = len(mine)
        row[f"sum_budget_{level}_mm"] = math.fsum((1e3 * mine).tolist())
    return row


def _sums(result: EpisodeScore, t: int, chosen: np.ndarray, prefix: str) -> TableRow:
    """Count and sum a target over the chosen frames (F,) bool; sums are of finite values."""
    row: TableRow = {
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
    for name in SUMS:
        mine = values[name][chosen, t]
        mine = mine[np.isfinite(mine)]
        row[f"{prefix}n_{name}"] = len(mine)
        row[f"{prefix}sum_{name}"] = math.fsum(mine.tolist())
    return row


def failed_row(failure: EpisodeFailure, target: str) -> TableRow:
    """A row of `EPISODES` without a frame, so that the failure is counted."""
    zero = {"int64": 0, "double": 0.0, "string": "", "bool": False}
    row: TableRow = {column.name: zero[str(column.type)] for column in EPISODES}
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


def event_rows(episode: Episode) -> tuple[TableRow, ...]:
    """The rows of `EVENTS` of an episode."""
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
