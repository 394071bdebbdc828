"""What the page's player needs of an episode: small numbers, packed, and its film.

Lengths are whole 0.1 mm, pixels whole 0.1 px, times ms; a series is its first value and then
differences, None where there is nothing. The script `player.js` reads exactly this.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.interfaces import STATUSES
from pjpdaf.targets import TARGETS
from reports.run.films import read_film
from reports.run.load import SavedRun
from reports.score.records import VIEWS
from reports.summary.tables import LABELS

Key = tuple[str, int]  # scenario, seed
FILM_BYTES = 15_500_000  # of all whole films on a page
STILL_BYTES = 620_000  # of the frames kept of other episodes
_SHAPE = ("x_px", "y_px", "a_px", "b_px", "angle_rad")


@dataclass(frozen=True, eq=False)
class Take:
    """One episode with a result, as rows of a run's tables.

    frames: F * T rows, targets in order within a frame; events, seen, cameras: its rows.
    """

    scenario: str
    seed: int
    frames: pd.DataFrame
    events: pd.DataFrame
    seen: pd.DataFrame
    cameras: pd.DataFrame

    def column(self, name: str) -> np.ndarray:
        """A column of `frames` as (F, T)."""
        return np.asarray(self.frames[name]).reshape(-1, len(TARGETS))

    def points_mm(self, kind: str) -> Floats:
        """Positions of "truth" or "estimate", (F, T, 3) [mm]."""
        axes = [self.column(f"{kind}_{axis}_m") for axis in "xyz"]
        return np.asarray(1e3 * np.stack(axes, axis=-1).astype(np.float64))

    @property
    def index(self) -> np.ndarray:
        """Number of each frame (F,)."""
        numbers: np.ndarray = self.column("frame")[:, 0]
        return numbers


@dataclass(frozen=True, eq=False)
class Film:
    """Frames of an episode in the page: bytes of each, one after the other; whole: all of them."""

    pictures: Mapping[int, bytes]
    whole: bool

    @property
    def sizes(self) -> str:
        """Where each frame is, such as "0:5120 1:4980"."""
        return " ".join(f"{frame}:{len(webp)}" for frame, webp in self.pictures.items())

    @property
    def packed(self) -> str:
        """All of it in base64."""
        return base64.b64encode(b"".join(self.pictures.values())).decode()


def takes(run: SavedRun) -> Iterator[Take]:
    """All episodes of a run that have a result, in its order."""
    tables = [run.events, run.detections, run.cameras]
    parts = [dict(iter(table.groupby(["scenario", "seed"], sort=False))) for table in tables]
    for (scenario, seed), frames in run.frames.groupby(["scenario", "seed"], sort=False):
        rows = [
            part.get((scenario, seed), table.iloc[:0])
            for part, table in zip(parts, tables, strict=True)
        ]
        yield Take(str(scenario), int(seed), frames, *rows)


def pack(take: Take) -> str:
    """An episode for the page, gzip and base64."""
    text = json.dumps(episode_data(take), separators=(",", ":"), allow_nan=False)
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def episode_data(take: Take) -> dict[str, Any]:
    """An episode as plain values."""
    F = len(take.index)
    status = take.column("status")
    merged = take.column("merged").astype(bool)
    labels = take.column("labels")[:, 0]
    changes = [i for i in range(F) if i == 0 or labels[i] != labels[i - 1]]
    return {
        "scenario": take.scenario,
        "seed": take.seed,
        "frames": _deltas(take.index),
        "ms": _deltas(take.column("time_s")[:, 0] * 1e3),
        "truth": _series(take.points_mm("truth").reshape(F, -1) * 10),
        "said": _series(take.points_mm("estimate").reshape(F, -1) * 10),
        "mm": _series(take.column("error_mm") * 10),
        "px": _series(take.column("err_acc_px") * 10),
        "status": ["".join(str(STATUSES.index(s)) for s in status[:, t]) for t in range(3)],
        "merged": ["".join("01"[int(m)] for m in merged[:, t]) for t in range(3)],
        "labels": [[i, str(labels[i])] for i in changes if labels[i]],
        "seen": [_seen(take, view) for view in VIEWS],
        "cameras": [_camera(row) for row in take.cameras.to_dict("records")],
        "events": [
            {
                "kind": str(event["kind"]),
                "words": event_words(event),
                "target": TARGETS.index(event["target"]),
                "first": int(event["first_frame"]),
                "last": int(event["last_frame"]),
            }
            for event in take.events.to_dict("records")
        ],
    }


def event_words(event: Mapping[Any, Any]) -> str:
    """What happened, from a row of the table of events."""
    who = LABELS[event["target"]]
    return {
        "swap": "hands swapped",
        "capture": f"{who} captured by {LABELS.get(event['other'], '?')}",
        "lost": f"{who} lost",
        "recovered": f"{who} recovered",
    }[event["kind"]]


def worst_frame(take: Take, pictured: Collection[int] = ()) -> int:
    """The frame with the largest error, all targets together; errors over 300 mm are all as bad.

    One of those that have a picture, where it is nearly as bad.
    """
    errors = take.column("error_mm").astype(np.float64)
    cost = np.minimum(np.nan_to_num(errors, nan=300.0), 300.0).sum(axis=1)
    # Before the first estimate there is nothing to see.
    cost[~np.isfinite(errors).any(axis=1)] = -1.0
    shown = np.where(np.isin(take.index, list(pictured)), cost, -1.0)
    if shown.max() >= 0.8 * cost.max():
        cost = shown
    return int(take.index[int(cost.argmax())])


def films(run: SavedRun, order: Sequence[Key], budget: tuple[int, int]) -> dict[Key, Film]:
    """Films of a run for the page, in this order as far as the budgets go.

    budget: bytes of whole films and of kept frames. A whole film that does not fit is left out; the
    kept frames of all other episodes are thinned evenly until they fit.
    """
    whole_left, still_left = budget
    entries = {(e["scenario"], int(e["seed"])): e for e in run.meta["films"]}
    found: dict[Key, Film] = {}
    kept: dict[Key, dict[int, bytes]] = {}
    for key in [k for k in order if k in entries]:
        entry = entries[key]
        pictures = read_film(run, entry["file"])
        if not entry["whole"]:
            kept[key] = pictures
            continue
        size = sum(map(len, pictures.values()))
        if size <= whole_left:
            whole_left -= size
            found[key] = Film(pictures, whole=True)
    most = max((len(p) for p in kept.values()), default=0)
    while most and sum(len(w) for p in kept.values() for w in p.values()) > still_left:
        most -= 1
        kept = {key: _thinned(pictures, most) for key, pictures in kept.items()}
    return found | {key: Film(p, whole=False) for key, p in kept.items() if p}


def _thinned(pictures: Mapping[int, bytes], most: int) -> dict[int, bytes]:
    """At most `most` pictures, evenly spread, the first and the last among them."""
    if len(pictures) <= most:
        return dict(pictures)
    places = np.unique(np.linspace(0, len(pictures) - 1, most).round().astype(int))
    frames = list(pictures)
    return {frames[i]: pictures[frames[i]] for i in places}


def _seen(take: Take, view: str) -> dict[str, Any]:
    """n: detections in each frame; v: x, y, a, b [0.1 px], angle [0.01 rad] of all, in order."""
    mine = take.seen[take.seen["view"] == view]
    counts = mine.groupby("frame").size().reindex(take.index, fill_value=0)
    scale = np.array([10.0, 10.0, 10.0, 10.0, 100.0])
    values = mine[list(_SHAPE)].to_numpy(dtype=np.float64) * scale
    return {
        "n": "".join(str(min(int(n), 9)) for n in counts),
        "v": [_integers(column) for column in _at_most_nine(values, counts).T],
    }


def _at_most_nine(values: Floats, counts: pd.Series) -> Floats:
    """The first nine of each frame: their number is one digit."""
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
    """Columns (F, n) as differences."""
    return [_deltas(column) for column in values.astype(np.float64).T]


def _deltas(values: np.ndarray) -> list[int | None]:
    """Whole numbers as differences from the last one that is there; None for NaN and infinity."""
    out: list[int | None] = []
    last = 0
    for value in _integers(values):
        out.append(None if value is None else value - last)
        last = last if value is None else value
    return out


def _integers(values: np.ndarray) -> list[int | None]:
    rounded = np.round(np.asarray(values, dtype=np.float64))
    return [int(v) if np.isfinite(v) else None for v in rounded.tolist()]
