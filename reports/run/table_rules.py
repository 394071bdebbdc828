"""Rules that the tables of a saved run keep; the first row that breaks a rule is named."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from pjpdaf.interfaces import STATUSES
from pjpdaf.targets import TARGETS
from reports.run.schema import HOTA, TABLES
from reports.score.events import KINDS
from reports.score.gospa import CUT_OFF_M
from reports.score.mot import ALPHAS
from reports.score.records import VIEWS
from reports.score.score import BANDS_M

KEY = ["scenario", "seed"]
# Columns that together are there once.
KEYS = {
    "frames": [*KEY, "frame", "target"],
    "episodes": [*KEY, "target"],
    "tracking": KEY,
    "cameras": [*KEY, "view"],
}
WORDS: dict[str, tuple[str, ...]] = {
    "target": TARGETS,
    "other": (*TARGETS, ""),
    "kind": KINDS,
    "view": VIEWS,
    "status": STATUSES,
}
_COUNT_MAX = float(2**53)
_ROUNDING = 1.0 + 1e-9
_GOSPA_MAX_MM = 1e3 * CUT_OFF_M * np.sqrt(len(TARGETS))  # a frame: nothing tracked, all false
_BANDS = [f"within_{round(band * 1000)}" for band in sorted(BANDS_M)]
_LENGTHS = {"K": (9,), "R_cw": (9,), "t_cw": (3,), "distortion": (0, 4, 5, 8, 12, 14)}
_LENGTHS |= {f"hota_{part.name}": (len(ALPHAS),) for part in HOTA}
_NEVER_NEGATIVE = re.compile(
    r"(merged_)?sum_|clear_sum|median_|(error|lateral|surface)_mm$|error_\w+_px$|err_acc_px$"
    r"|(duration|start|time)_s$|(a|b|area)_px$|nees$|fps$|truth_speed_mps$|within_|n_"
)
_SHARE = re.compile(r"visible_\w+$|exchange_probability$|exchanged$")
# A median without any value, and values of a target that is not there, are NaN.
_MAY_BE_NAN = re.compile(r"median_|truth_speed_mps$")


class BrokenRule(NamedTuple):
    """A rule that a row breaks: number of the row (from 0), and the rule in words."""

    row: int
    words: str


def first_broken_rule(name: str, frame: pd.DataFrame) -> BrokenRule | None:
    """The first rule that the table `name` breaks; None where it keeps them all."""
    for good, words in _rules(name, frame):
        if not good.all():
            row = int(np.argmin(good))
            return BrokenRule(row, words(row))
    return None


Words = Callable[[int], str]
Rule = tuple[np.ndarray, Words]


def _rules(name: str, frame: pd.DataFrame) -> Iterator[Rule]:
    for column in TABLES[name]:
        if column.name in frame:  # a run of an earlier version has fewer
            yield from _rules_of_column(name, column, frame[column.name])
    if name in KEYS:
        once = ~frame.duplicated(KEYS[name]).to_numpy()
        yield once, lambda row: "is there twice"
    if name == "episodes":
        yield from _rules_of_episodes(frame)
    elif name == "tracking":
        yield _at_most(frame, "clear_matches", "clear_truths")
        yield _at_most(frame, "clear_switches", "clear_matches")
        worst = frame["frames"].to_numpy() * _GOSPA_MAX_MM * _ROUNDING
        yield (
            frame["sum_gospa_mm"].to_numpy() <= worst,
            lambda row: f"sum_gospa_mm is above its most, {worst[row]:g}",
        )
    elif name == "events":
        yield _at_most(frame, "first_frame", "last_frame")


def _rules_of_column(table: str, column: pa.Field, values: pd.Series) -> Iterator[Rule]:
    name, kind = column.name, column.type
    if pa.types.is_list(kind):
        yield from _rules_of_lists(name, values)
        return
    if not pa.types.is_floating(kind):
        yield ~values.isna().to_numpy(), lambda row: f"{name} is empty"
        if pa.types.is_integer(kind):
            least = 1.0 if table == "tracking" and name == "frames" else 0.0
            yield _between(name, values, least, _COUNT_MAX)
        elif name in WORDS:
            known = ", ".join(filter(None, WORDS[name]))
            yield (
                values.isin(WORDS[name]).to_numpy(),
                lambda row: f"{name} must be of {known}, got {str(values.iloc[row])[:60]!r}",
            )
        return
    numbers = values.to_numpy(dtype=np.float64)
    # Where frames were not tracked, or a plug-in answered without sense, a frame has NaN or worse.
    may_be_nan = table in ("frames", "detections") or _MAY_BE_NAN.match(name)
    if not may_be_nan:
        yield np.isfinite(numbers), lambda row: f"{name} is not a finite number"
    if _NEVER_NEGATIVE.match(name):
        yield ~(numbers < 0.0), lambda row: f"{name} is {numbers[row]:g}, below 0"
    if _SHARE.match(name):
        yield (
            ~((numbers < 0.0) | (numbers > 1.0)),
            lambda row: f"{name} is {numbers[row]:g}, not within 0..1",
        )


def _rules_of_lists(name: str, values: pd.Series) -> Iterator[Rule]:
    yield ~values.isna().to_numpy(), lambda row: f"{name} is empty"
    lengths = _LENGTHS[name]
    good = np.array([len(cell) in lengths for cell in values], dtype=bool)
    yield good, lambda row: f"{name} has {len(values.iloc[row])} numbers, not {lengths[0]}"
    low = 0.0 if name.startswith("hota_") else -np.inf
    inside = [bool(np.isfinite(cell).all() and np.all(np.asarray(cell) >= low)) for cell in values]
    yield np.array(inside, dtype=bool), lambda row: f"{name} has a number out of range"


def _rules_of_episodes(frame: pd.DataFrame) -> Iterator[Rule]:
    played = (frame["failure"] == "").to_numpy()
    frames = frame["frames"].to_numpy()
    yield ~played | (frames >= 1), lambda row: "frames is 0 in an episode without a failure"
    yield played | (frames == 0), lambda row: "frames is above 0 in an episode with a failure"
    for column in frame.columns:
        if re.match(r"covered$|within_|n_|swapped_frames$|lost_frames$|budget_frames$", column):
            yield _at_most(frame, column, "frames")
        if column.startswith("merged_") and column != "merged":
            yield _at_most(frame, column, column.removeprefix("merged_"))
    for nearer, farther in pairwise(_BANDS):
        yield _at_most(frame, nearer, farther)
    for ever, times in (("swapped", "swaps"), ("captured", "captures"), ("lost", "losses")):
        had = frame[f"ever_{ever}"].to_numpy(dtype=bool)
        yield _stating(
            had | (frame[times].to_numpy() == 0), f"ever_{ever} is false, but {times} is above 0"
        )
    # The three targets of an episode share what belongs to the episode.
    for column in ("group", "digest", "failure", "fps", "frames", "redrawn"):
        first = frame.groupby(KEY, sort=False)[column].transform("first")
        same = (first == frame[column]).to_numpy()
        yield _stating(same, f"{column} is not that of the episode's other targets")


def _stating(good: np.ndarray, words: str) -> Rule:
    return good, lambda row: words


def _between(name: str, values: pd.Series, low: float, high: float) -> Rule:
    numbers = values.to_numpy()
    return (
        (numbers >= low) & (numbers <= high),
        lambda row: f"{name} is {numbers[row]}, not within {low:.0f}..{high:.0f}",
    )


def _at_most(frame: pd.DataFrame, column: str, other: str) -> Rule:
    a, b = frame[column].to_numpy(), frame[other].to_numpy()
    slack = _ROUNDING if frame[column].dtype.kind == "f" else 1
    return a <= b * slack, lambda row: f"{column} is {a[row]:g}, more than {other}, {b[row]:g}"
