"""The summary of a run: a row per scenario and target, as records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pjpdaf.targets import HEAD, TARGETS
from reports.run.load import SavedRun
from reports.score.records import STAGES
from reports.score.score import quantile
from reports.summary.text import number
from reports.words import ALL

_FRAME_COLUMNS = ["scenario", "target", "merged", "error_mm", "err_acc_px"]
_EPISODE_COLUMNS = [
    *("scenario", "seed", "target", "failure", "within_50", "within_100", "merged_within_100"),
    *("ever_swapped", "ever_captured", "ever_lost"),
]


@dataclass(frozen=True)
class SummaryRow:
    """One target in one scenario ("all" pools them). Ratios are of ALL frames, waiting frames too.

    median_mm, p90_mm: 3-D error against the centre, err_acc_px: median of Eq. 4.1; a frame without
    an estimate counts as infinite. within_50, within_100, merged_within_100: shares 0-1, NaN
    without frames. episodes counts those without a result too, `failed` of them; swapped is None
    for the head; swapped, captured, lost: episodes in which it happened at least once.
    """

    scenario: str
    target: str
    frames: int
    covered: int
    median_mm: float
    p90_mm: float
    err_acc_px: float
    within_50: float
    within_100: float
    merged_frames: int
    merged_within_100: float
    episodes: int
    failed: int
    swapped: int | None
    captured: int
    lost: int


@dataclass(frozen=True)
class StageTimes:
    """Mean wall time per frame and stage [ms], NaN where nothing was timed."""

    scenario: str
    render_ms: float
    detect_ms: float
    track_ms: float


@dataclass(frozen=True)
class Summary:
    """rows: per scenario head, right, left, all; total: the same over all scenarios.

    hands_mm: scenario (and "all") -> median 3-D error of both hands [mm]. lag_frames: by which the
    estimates came later than their frames.
    """

    name: str
    lag_frames: int
    complete: bool
    rows: tuple[SummaryRow, ...]
    total: tuple[SummaryRow, ...]
    hands_mm: Mapping[str, float]
    times: tuple[StageTimes, ...]
    total_times: StageTimes
    failures: tuple[tuple[str, int, str], ...]

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Names in order."""
        return tuple(dict.fromkeys(row.scenario for row in self.rows))

    @property
    def overall(self) -> SummaryRow:
        """All targets of all scenarios."""
        return self.total[-1]


def summarise(run: SavedRun) -> Summary:
    """The summary of a saved run."""
    scenarios = list(dict.fromkeys(run.episodes["scenario"]))
    # Each of the many parts that are taken of a table costs as much as it has columns.
    every_frame, every_episode = run.frames[_FRAME_COLUMNS], run.episodes[_EPISODE_COLUMNS]
    frames = dict(list(every_frame.groupby("scenario", sort=False)))
    episodes = dict(list(every_episode.groupby("scenario", sort=False)))
    rows = [
        row
        for name in scenarios
        for row in _rows(name, frames.get(name, every_frame.iloc[:0]), episodes[name])
    ]
    timing: list[dict[str, Any]] = list(run.meta["timing"])
    failed = run.episodes[run.episodes["failure"] != ""].drop_duplicates(["scenario", "seed"])
    return Summary(
        name=run.name,
        lag_frames=int(run.meta.get("lag_frames", 0)),
        complete=bool(run.meta["complete"]),
        rows=tuple(rows),
        total=tuple(_rows(ALL, every_frame, every_episode)),
        hands_mm={ALL: _hands_mm(every_frame)} | {name: _hands_mm(frames[name]) for name in frames},
        times=tuple(_times(n, [t for t in timing if t["scenario"] == n]) for n in scenarios),
        total_times=_times(ALL, timing),
        failures=tuple(
            (str(s), int(seed), str(reason))
            for s, seed, reason in zip(
                failed["scenario"], failed["seed"], failed["failure"], strict=True
            )
        ),
    )


def time_text(times: StageTimes) -> str:
    """render / detect / track in ms."""
    return " / ".join(number(getattr(times, f"{stage}_ms")) for stage in STAGES)


def _rows(scenario: str, frames: pd.DataFrame, episodes: pd.DataFrame) -> list[SummaryRow]:
    rows = []
    for target in (*TARGETS, ALL):
        mine = frames if target == ALL else frames[frames["target"] == target]
        played = episodes if target == ALL else episodes[episodes["target"] == target]
        merged = mine[mine["merged"].to_numpy(dtype=bool)]
        errors = mine["error_mm"].to_numpy(dtype=np.float64)
        rows.append(
            SummaryRow(
                scenario=scenario,
                target=target,
                frames=len(mine),
                covered=int(np.isfinite(errors).sum()),
                median_mm=quantile(errors, 0.5),
                p90_mm=quantile(errors, 0.9),
                err_acc_px=quantile(mine["err_acc_px"].to_numpy(dtype=np.float64), 0.5),
                within_50=_share(int(played["within_50"].sum()), len(mine)),
                within_100=_share(int(played["within_100"].sum()), len(mine)),
                merged_frames=len(merged),
                merged_within_100=_share(int(played["merged_within_100"].sum()), len(merged)),
                episodes=_episodes(played),
                failed=_episodes(played[played["failure"] != ""]),
                swapped=None if target == TARGETS[HEAD] else _ever(played, "ever_swapped"),
                captured=_ever(played, "ever_captured"),
                lost=_ever(played, "ever_lost"),
            )
        )
    return rows


def _hands_mm(frames: pd.DataFrame) -> float:
    hands = frames[frames["target"] != TARGETS[HEAD]]
    return quantile(hands["error_mm"].to_numpy(dtype=np.float64), 0.5)


def _share(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")


def _episodes(rows: pd.DataFrame) -> int:
    return len(set(zip(rows["scenario"], rows["seed"], strict=True)))


def _ever(rows: pd.DataFrame, column: str) -> int:
    """Episodes in which it happened to any of the rows' targets."""
    return _episodes(rows.loc[rows[column].to_numpy(dtype=bool), ["scenario", "seed"]])


def _times(scenario: str, timing: list[dict[str, Any]]) -> StageTimes:
    frames = sum(int(t["frames"]) for t in timing)
    mean = {}
    for stage in STAGES:
        spent = sum(float(t["stage_s"].get(stage, 0.0)) for t in timing)
        mean[stage] = 1e3 * spent / frames if frames and spent > 0 else float("nan")
    return StageTimes(scenario, mean["render"], mean["detect"], mean["track"])
