"""Data of an episode for the page's player: small whole numbers, packed.

Lengths are whole 0.1 mm, pixels whole 0.1 px, times ms, probabilities 0.001; a series is its first
value and then differences, None where there is no value. `player_data.js` reads this form.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import STATUSES
from pjpdaf.targets import RIGHT_HAND, TARGETS
from reports.page.episode_tables import EpisodeTables
from reports.page.packing import json_text
from reports.page.time_lanes import time_lanes
from reports.score.records import VIEWS
from reports.words import event_text, labels_text
from sim.event_names import is_merge

_SHAPE = ("x_px", "y_px", "a_px", "b_px", "angle_rad")


def pack(episode: EpisodeTables) -> str:
    """Pack an episode for the page: JSON in gzip in base64."""
    return json_text(episode_data(episode))


def episode_data(episode: EpisodeTables) -> dict[str, Any]:
    """An episode's numbers as plain values."""
    F = len(episode.index)
    status = episode.column("status")
    merged = episode.column("merged").astype(bool)
    phases = [phase_text(str(text)) for text in episode.column("labels")[:, 0]]
    changes = [i for i in range(F) if i == 0 or phases[i] != phases[i - 1]]
    return {
        "scenario": episode.scenario,
        "seed": episode.seed,
        "frames": _deltas(episode.index),
        "ms": _deltas(episode.column("time_s")[:, 0] * 1e3),
        "truth": _series(episode.points_mm("truth").reshape(F, -1) * 10),
        "estimates": _series(episode.points_mm("estimate").reshape(F, -1) * 10),
        "mm": _series(episode.column("error_mm") * 10),
        "px": _series(episode.column("err_acc_px") * 10),
        "exchange": _deltas(episode.column("exchange_probability")[:, RIGHT_HAND] * 1e3),
        "status": ["".join(str(STATUSES.index(s)) for s in status[:, t]) for t in range(3)],
        "merged": ["".join("01"[int(m)] for m in merged[:, t]) for t in range(3)],
        "labels": [[i, phases[i]] for i in changes],
        "detections": [_detections(episode, view) for view in VIEWS],
        "cameras": [_camera(row) for row in episode.cameras.to_dict("records")],
        "lanes": [
            {
                "kind": lane.kind,
                "text": lane.text,
                "target": lane.target,
                "spans": [list(span) for span in lane.spans],
            }
            for lane in time_lanes(episode)
        ],
        "events": [
            {
                "kind": str(event["kind"]),
                "text": event_text(event),
                "target": TARGETS.index(event["target"]),
                "first": int(event["first_frame"]),
                "last": int(event["last_frame"]),
            }
            for event in episode.events.to_dict("records")
        ],
    }


def phase_text(labels: str) -> str:
    """What a person does in a frame, without the merges, which have lanes of their own."""
    return labels_text(name for name in labels.split(";") if not is_merge(name))


def worst_frame(episode: EpisodeTables, pictured: Collection[int] = ()) -> int:
    """Number of the frame with the largest error, summed over the targets, 300 mm at most each.

    pictured: frames with a picture; the largest of these is preferred where it is nearly as bad.
    """
    errors = episode.column("error_mm").astype(np.float64)
    cost = np.minimum(np.nan_to_num(errors, nan=300.0), 300.0).sum(axis=1)
    # Frames without any estimate have nothing to show.
    cost[~np.isfinite(errors).any(axis=1)] = -1.0
    shown = np.where(np.isin(episode.index, list(pictured)), cost, -1.0)
    if shown.max() >= 0.8 * cost.max():
        cost = shown
    return int(episode.index[int(cost.argmax())])


def _detections(episode: EpisodeTables, view: str) -> dict[str, Any]:
    """n: count of each frame, a digit; v: x, y, a, b [0.1 px], angle [0.01 rad] of all."""
    mine = episode.detections[episode.detections["view"] == view]
    counts = mine.groupby("frame").size().reindex(episode.index, fill_value=0)
    scale = np.array([10.0, 10.0, 10.0, 10.0, 100.0])
    values = mine[list(_SHAPE)].to_numpy(dtype=np.float64) * scale
    return {
        "n": "".join(str(min(int(n), 9)) for n in counts),
        "v": [_integers(column) for column in _at_most_nine(values, counts).T],
    }


def _at_most_nine(values: Floats, counts: pd.Series) -> Floats:
    """Keep the first nine of each frame, so that their count is a digit."""
    place = np.concatenate([np.arange(n) for n in counts]) if len(values) else np.zeros(0)
    return values[place < 9]


def _camera(row: Mapping[Any, Any]) -> dict[str, Any]:
    K = np.array(row["K"]).reshape(3, 3)
    R_cw = np.array(row["R_cw"]).reshape(3, 3)
    t_cw = np.array(row["t_cw"])
    P = K @ np.column_stack([R_cw, t_cw])
    return {
        "w": int(row["width_px"]),
        "h": int(row["height_px"]),
        "P": [float(f"{v:.8g}") for v in P.ravel()],
        "centre": [round(float(v), 4) for v in -R_cw.T @ t_cw],
    }


def _series(values: np.ndarray) -> list[list[int | None]]:
    """Turn columns (F, n) into differences."""
    return [_deltas(column) for column in values.astype(np.float64).T]


def _deltas(values: np.ndarray) -> list[int | None]:
    """Differences of whole numbers from the last finite value; None for NaN and infinity."""
    out: list[int | None] = []
    last = 0
    for value in _integers(values):
        out.append(None if value is None else value - last)
        last = last if value is None else value
    return out


def _integers(values: np.ndarray) -> list[int | None]:
    rounded = np.round(np.asarray(values, dtype=np.float64))
    return [int(v) if np.isfinite(v) else None for v in rounded.tolist()]
