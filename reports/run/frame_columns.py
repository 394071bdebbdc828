"""Columns of an episode with a value a frame and target, or a detection."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import HANDS, TARGETS
from reports.run.schema import COVARIANCE, DETECTIONS, FRAMES
from reports.score.exchange import exchange_of
from reports.score.records import (
    VIEWS,
    Episode,
)
from reports.score.score import EpisodeScore


def frame_columns(episode: Episode, result: EpisodeScore) -> dict[str, list[object]]:
    """Columns of `FRAMES`, F * T values each: frame by frame, targets in order within a frame."""
    outcomes = episode.frames
    F, T = result.error_m.shape
    exchange = exchange_of(episode)
    is_hand = np.array([target in HANDS for target in range(T)])
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
        "exchange_probability": np.where(is_hand, exchange.stated[:, None], np.nan),
        "exchanged": np.where(is_hand, exchange.exchanged[:, None], np.nan),
    }
    for a, axis in enumerate("xyz"):
        numbers[f"truth_{axis}_m"] = np.stack([o.truth.centres_m[:, a] for o in outcomes])
        numbers[f"surface_{axis}_m"] = np.stack([o.truth.surfaces_m[:, a] for o in outcomes])
        numbers[f"estimate_{axis}_m"] = np.stack([o.estimates.positions_m[:, a] for o in outcomes])
    for pair in COVARIANCE:
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


def detection_columns(episode: Episode) -> dict[str, list[object]]:
    """Columns of `DETECTIONS`: frame by frame, view by view, in the detector's order.

    That is no order of targets, which the detector does not know.
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


def _plain(values: Floats) -> list[object]:
    """Flatten to a list with one kind of NaN and of zero: bytes depend on values alone."""
    flat = np.where(np.isnan(values), np.nan, values + 0.0).ravel()
    return list(flat.tolist())
