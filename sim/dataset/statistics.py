"""Statistics of a data set: counts and histograms of its labels, read sequence by sequence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import FileError
from pjpdaf.targets import LEFT_HAND, RIGHT_HAND, TARGETS
from sim.dataset.files.layout import TRUTH
from sim.dataset.histograms import BINS, Histogram, counted
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED, VISIBLE
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

HANDS = (RIGHT_HAND, LEFT_HAND)
_PAIRS = tuple(combinations(TARGETS, 2))
_POINTS = tuple(f"{TARGETS[target]}:{name}" for target, name in KEYPOINTS)
_STATUSES = VISIBLE + 1


@dataclass(frozen=True)
class Statistics:
    """Counts of a data set.

    scenarios: sequences and stereo frames by scenario; lost_pictures: by view; merged: frames by
    "right_hand + left_hand, left"; merged_frames: with any pair merged in any view;
    ambiguous_frames: both hands are one blob in both views; keypoints: by "head:chin" the numbers
    of not labelled, occluded and visible over both views; object_rows: of objects.parquet;
    histograms: by the names of BINS.
    """

    sequences: int
    frames: int
    seconds: float
    scenarios: Mapping[str, tuple[int, int]]
    lost_pictures: Mapping[str, int]
    merged: Mapping[str, int]
    merged_frames: int
    ambiguous_frames: int
    keypoints: Mapping[str, tuple[int, int, int]]
    object_rows: int
    histograms: Mapping[str, Histogram]

    def record(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "sequences": self.sequences,
            "frames": self.frames,
            "seconds": round(self.seconds, 3),
            "scenarios": {
                name: {"sequences": sequences, "frames": frames}
                for name, (sequences, frames) in self.scenarios.items()
            },
            "lost_pictures": dict(self.lost_pictures),
            "merged": dict(self.merged),
            "merged_frames": self.merged_frames,
            "ambiguous_frames": self.ambiguous_frames,
            "keypoints": {
                name: {"not_labelled": none, "occluded": occluded, "visible": visible}
                for name, (none, occluded, visible) in self.keypoints.items()
            },
            "object_rows": self.object_rows,
            "histograms": {
                name: {
                    "title": histogram.bins.title,
                    "unit": histogram.bins.unit,
                    "edges": list(histogram.bins.edges),
                    "counts": {s: list(counts) for s, counts in histogram.counts.items()},
                    "missing": histogram.missing,
                }
                for name, histogram in self.histograms.items()
            },
        }


def statistics_of(dataset: Dataset) -> Statistics:
    """Statistics of all finished sequences, of which one at a time is in memory.

    Raises FileError for a damaged sequence.
    """
    totals = _Totals()
    for sequence in dataset.sequences:
        # A copy keeps its tables to itself, and they go with it.
        totals.add(replace(sequence))
    return totals.statistics()


class _Totals:
    """Running totals over sequences."""

    def __init__(self) -> None:
        self._counts: dict[str, dict[str, NDArray[np.int64]]] = {name: {} for name in BINS}
        self._missing = dict.fromkeys(BINS, 0)
        self._scenarios: dict[str, tuple[int, int]] = {}
        self._seconds = 0.0
        self._lost = dict.fromkeys(CAMERAS, 0)
        self._merged = {f"{a} + {b}, {view}": 0 for a, b in _PAIRS for view in CAMERAS}
        self._merged_frames = self._ambiguous = self._objects = 0
        self._keypoints = {name: np.zeros(_STATUSES, np.int64) for name in _POINTS}

    def add(self, sequence: StoredSequence) -> None:
        """Add a sequence."""
        frames, rows = sequence.frame_count, sequence.truth
        # The table is untrusted, whatever the manifest says.
        names = rows["target"].to_numpy()
        if len(rows) != frames * len(TARGETS) or list(names) != list(TARGETS) * frames:
            raise FileError(
                sequence.folder / TRUTH,
                f"must have a row for each of {', '.join(TARGETS)} in "
                f"each of {frames} frames, in this order",
            )
        scenario = str(sequence.entry.get("scenario", "unnamed"))
        before = self._scenarios.get(scenario, (0, 0))
        self._scenarios[scenario] = before[0] + 1, before[1] + frames
        self._seconds += frames / sequence.fps
        self._objects += len(sequence.objects)
        self._add_views(rows)
        self._add_places(sequence, rows)
        self._add_merged(rows)
        self._add_keypoints(sequence, rows)
        self._count("skin_tone", "sequences", np.array([skin_ita_deg(sequence.recipe)]))

    def statistics(self) -> Statistics:
        """The totals as a record."""
        return Statistics(
            sequences=sum(n for n, _ in self._scenarios.values()),
            frames=sum(n for _, n in self._scenarios.values()),
            seconds=self._seconds,
            scenarios=dict(sorted(self._scenarios.items())),
            lost_pictures=self._lost,
            merged=self._merged,
            merged_frames=self._merged_frames,
            ambiguous_frames=self._ambiguous,
            keypoints={
                name: (int(n[0]), int(n[1]), int(n[2])) for name, n in self._keypoints.items()
            },
            object_rows=self._objects,
            histograms={
                name: Histogram(
                    bins,
                    {s: tuple(n.tolist()) for s, n in self._counts[name].items()},
                    self._missing[name],
                )
                for name, bins in BINS.items()
            },
        )

    def _count(self, name: str, series: str, values: Floats) -> None:
        counts, missing = counted(values, BINS[name].edges)
        mine = self._counts[name]
        mine[series] = mine.get(series, np.zeros_like(counts)) + counts
        self._missing[name] += missing

    def _add_views(self, rows: pd.DataFrame) -> None:
        for view in CAMERAS:
            self._lost[view] += int((~_by_target(rows, f"arrived_{view}", bool)[0]).sum())
            shown = _by_target(rows, f"visible_fraction_{view}", np.float64)
            amodal = _by_target(rows, f"amodal_{view}_px", np.float64)
            cut = _by_target(rows, f"truncation_{view}", np.float64)
            for t, target in enumerate(TARGETS):
                inside = np.where(amodal[t] > 0, shown[t], np.nan)
                self._count("visible_fraction", f"{target}, {view}", inside)
                self._count("truncation", f"{target}, {view}", cut[t])

    def _add_places(self, sequence: StoredSequence, rows: pd.DataFrame) -> None:
        camera_w = sequence.rig.left.centre_w
        axes = [_by_target(rows, f"{a}_m", np.float64) for a in "xyz"]
        speeds = [_by_target(rows, f"v{a}_mps", np.float64) for a in "xyz"]
        for t, target in enumerate(TARGETS):
            places = np.stack([axis[t] for axis in axes], axis=-1)
            self._count("distance", target, np.linalg.norm(places - camera_w, axis=1))
            steps_m = np.linalg.norm(np.diff(places, axis=0), axis=1)
            self._count("motion", target, 1e3 * steps_m)
            if t in HANDS:
                speed = np.stack([axis[t] for axis in speeds], axis=-1)
                self._count("hand_speed", target, np.linalg.norm(speed, axis=1))

    def _add_merged(self, rows: pd.DataFrame) -> None:
        T = len(TARGETS)
        both: list[NDArray[np.bool_]] = []
        anywhere = np.zeros(len(rows) // T, np.bool_)
        for view in CAMERAS:
            merged = rows[f"merged_with_{view}"].to_numpy()
            for a, b in _PAIRS:
                mine = merged[TARGETS.index(a) :: T]
                here = np.array([b in list(others) for others in mine], np.bool_)
                self._merged[f"{a} + {b}, {view}"] += int(here.sum())
                anywhere |= here
                if TARGETS.index(a) in HANDS and TARGETS.index(b) in HANDS:
                    both.append(here)
        self._merged_frames += int(anywhere.sum())
        self._ambiguous += int(np.logical_and.reduce(both).sum())

    def _add_keypoints(self, sequence: StoredSequence, rows: pd.DataFrame) -> None:
        T = len(TARGETS)
        for view in CAMERAS:
            column = f"keypoint_status_{view}"
            for t, target in enumerate(TARGETS):
                names = [name for name in _POINTS if name.startswith(f"{target}:")]
                try:
                    status = np.array(list(rows[column].iloc[t::T]), np.int64)
                    if status.shape[1:] != (len(names),):
                        raise ValueError
                    if ((status < NOT_LABELLED) | (status > VISIBLE)).any():
                        raise ValueError
                except (TypeError, ValueError):
                    raise FileError(
                        sequence.folder / TRUTH,
                        f"{column} of {target} must be {len(names)} "
                        f"numbers from {NOT_LABELLED} to {VISIBLE} in each frame",
                    ) from None
                for k, name in enumerate(names):
                    self._keypoints[name] += np.bincount(status[:, k], minlength=_STATUSES)


def skin_ita_deg(recipe: Mapping[str, Any]) -> float:
    """Skin tone in a recipe, individual typology angle [deg]; NaN where it has none."""
    return recipe_value(recipe, "skin_ita")


def recipe_value(recipe: Mapping[str, Any], name: str) -> float:
    """A number among the drawn values of a recipe; NaN where it has none."""
    values = recipe.get("values")
    value = values.get(name) if isinstance(values, Mapping) else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        return math.nan
    return float(value)


def _by_target(rows: pd.DataFrame, column: str, dtype: type) -> NDArray[Any]:
    """A column as (T, frames), NaN for no value."""
    return np.asarray(rows[column].to_numpy(dtype)).reshape(-1, len(TARGETS)).T
