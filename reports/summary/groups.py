"""Figures of groups of scenarios, of each scenario, and of a whole run: the page's main table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.targets import RIGHT_HAND, TARGETS
from reports.run.load import SavedRun
from reports.run.schema import CLEAR, HOTA, IDENTITY
from reports.score.mot import (
    ClearCounts,
    HotaCounts,
    IdentityCounts,
    summed_clear,
    summed_hota,
    summed_identity,
)
from reports.score.score import quantile

Counts = TypeVar("Counts")


@dataclass(frozen=True)
class GroupRow:
    """Head and hands of some scenarios together. Ratios are of all frames, waiting frames too.

    median_mm, p90_mm, err_acc_px (a median): a frame without an estimate counts as infinite;
    merged_*: of target-frames that are merged in a view; nees: mean, 3 is ideal; mota, idf1, hota:
    shares (1 is best); gospa_mm: mean of the frames; swapped, lost: episodes in which it happened;
    exchange_*: frames with a stated probability that the hands are exchanged and hands apart, its
    mean, and the share of them that is exchanged;
    redrawn: episodes whose first draw could not be posed, redraws: draws thrown away in all.
    NaN where there is nothing to measure.
    """

    name: str
    group: str
    scenarios: int
    episodes: int
    failed: int
    frames: int
    median_mm: float
    p90_mm: float
    within_100: float
    merged_frames: int
    merged_median_mm: float
    merged_within_100: float
    err_acc_px: float
    nees: float
    mota: float
    idf1: float
    hota: float
    gospa_mm: float
    exchange_frames: int
    exchange_stated: float
    exchange_observed: float
    swapped: int
    lost: int
    redrawn: int
    redraws: int


def group_name(group: str) -> str:
    """A group for reading: "hand_and_hand" is "hand and hand"."""
    return group.replace("_", " ") or "no group"


def group_rows(run: SavedRun) -> tuple[GroupRow, ...]:
    """A row for each group of scenarios, in order of the run."""
    return _rows(run, "group")


def scenario_rows(run: SavedRun) -> tuple[GroupRow, ...]:
    """A row for each scenario, in order of the run."""
    return _rows(run, "scenario")


def whole_row(run: SavedRun) -> GroupRow:
    """All scenarios together."""
    return _row("all", "", run.episodes, run.frames, run.tracking)


def _rows(run: SavedRun, by: str) -> tuple[GroupRow, ...]:
    group_of: Mapping[str, str] = dict(
        zip(run.episodes["scenario"], run.episodes["group"], strict=True)
    )
    belongs = {
        name: table["scenario"].map(group_of) if by == "group" else table["scenario"]
        for name, table in (("frames", run.frames), ("tracking", run.tracking))
    }
    rows = []
    for name in dict.fromkeys(run.episodes[by]):
        group = name if by == "group" else group_of[name]
        rows.append(
            _row(
                group_name(name) if by == "group" else name,
                group_name(group),
                run.episodes[run.episodes[by] == name],
                run.frames[belongs["frames"] == name],
                run.tracking[belongs["tracking"] == name],
            )
        )
    return tuple(rows)


def _row(
    name: str, group: str, episodes: pd.DataFrame, frames: pd.DataFrame, tracking: pd.DataFrame
) -> GroupRow:
    errors = _values(frames, "error_mm")
    merged = frames["merged"].to_numpy(dtype=bool)
    once = episodes.drop_duplicates(["scenario", "seed"])
    nees = int(episodes["n_nees"].sum())
    counted = int(tracking["frames"].sum())
    hand = episodes[episodes["target"] == TARGETS[RIGHT_HAND]]  # the left hand's are the same
    judged = int(hand["exchange_frames"].sum())
    nan = float("nan")
    hota_counts = summed_hota(_counts(tracking, "hota", HOTA, HotaCounts))
    return GroupRow(
        name=name,
        group=group,
        scenarios=int(episodes["scenario"].nunique()),
        episodes=len(once),
        failed=int((once["failure"] != "").sum()),
        frames=len(frames) // len(TARGETS),
        median_mm=quantile(errors, 0.5),
        p90_mm=quantile(errors, 0.9),
        within_100=_share(int(episodes["within_100"].sum()), len(frames)),
        merged_frames=int(merged.sum()),
        merged_median_mm=quantile(errors[merged], 0.5),
        merged_within_100=_share(int(episodes["merged_within_100"].sum()), int(merged.sum())),
        err_acc_px=quantile(_values(frames, "err_acc_px"), 0.5),
        nees=float(episodes["sum_nees"].sum()) / nees if nees else nan,
        mota=summed_clear(_counts(tracking, "clear", CLEAR, ClearCounts)).mota,
        idf1=summed_identity(_counts(tracking, "identity", IDENTITY, IdentityCounts)).idf1,
        hota=hota_counts.hota if counted else nan,
        gospa_mm=float(tracking["sum_gospa_mm"].sum()) / counted if counted else nan,
        exchange_frames=judged,
        exchange_stated=_share(float(hand["sum_exchange_probability"].sum()), judged),
        exchange_observed=_share(int(hand["exchanged_frames"].sum()), judged),
        swapped=_ever(episodes, "ever_swapped"),
        lost=_ever(episodes, "ever_lost"),
        redrawn=int((once["redrawn"] > 0).sum()),
        redraws=int(once["redrawn"].sum()),
    )


def _counts(
    tracking: pd.DataFrame, prefix: str, fields: Sequence[Any], kind: type[Counts]
) -> list[Counts]:
    """The counts of each episode as records of this kind."""
    columns = [tracking[f"{prefix}_{f.name}"] for f in fields]
    return [kind(*values) for values in zip(*columns, strict=True)]


def _values(frames: pd.DataFrame, column: str) -> Floats:
    return np.asarray(frames[column], dtype=np.float64)


def _share(part: float, whole: int) -> float:
    return part / whole if whole else float("nan")


def _ever(rows: pd.DataFrame, column: str) -> int:
    """Episodes in which it happened to any target."""
    happened = rows.loc[rows[column].to_numpy(dtype=bool), ["scenario", "seed"]]
    return len(happened.drop_duplicates())
