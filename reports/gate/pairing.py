"""Two saved runs episode by episode: whether they played the same, and a row of values of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.errors import NotComparable
from reports.run.load import SavedRun
from reports.run.motion_mark import same_motion
from reports.run.schema import columns_since
from reports.score.gospa import CUT_OFF_M

# Beyond this distance a target is lost; how far beyond is chance, and would dominate the mean.
CAP_MM, CAP_PX = 1e3 * CUT_OFF_M, 60.0
WORST_GOSPA_MM = 1e3 * CUT_OFF_M * float(np.sqrt(3.0))  # three missed, three false
KEY = ["scenario", "seed"]

Episode = tuple[str, int]


def episode_values(run: SavedRun) -> pd.DataFrame:
    """Tabulate the episodes in order of (scenario, seed): group, draw and a column per metric.

    draw: episodes of the same draw share their random numbers. A target without any estimate
    has the capped error, an episode without a result the worst value of every metric.
    """
    rows = run.episodes.copy()
    failed = (rows["failure"] != "").to_numpy()
    for column, cap in {"median_error_mm": CAP_MM, "median_err_acc_px": CAP_PX}.items():
        rows[column] = np.where(failed, cap, _capped(rows[column].to_numpy(dtype=float), cap))
    missed = rows["frames"] - rows["within_100"]
    rows["missed"] = np.where(failed, 1.0, missed / np.maximum(rows["frames"], 1))
    rows["failed"] = failed
    grouped = rows.groupby(KEY, sort=True)
    values = pd.DataFrame(
        {
            "group": grouped["group"].first(),
            "error_mm": grouped["median_error_mm"].mean(),
            "missed": grouped["missed"].mean(),
            "err_acc_px": grouped["median_err_acc_px"].mean(),
            "swapped": grouped["ever_swapped"].any() | grouped["failed"].any(),
            "lost": grouped["ever_lost"].any() | grouped["failed"].any(),
            "failed": grouped["failed"].any(),
        }
    )
    tracking = run.tracking.set_index(KEY)
    frames = np.maximum(tracking["frames"], 1)
    per_frame = (tracking["sum_gospa_mm"] / frames).reindex(values.index)
    values["gospa_mm"] = _capped(per_frame.to_numpy(dtype=float), WORST_GOSPA_MM)
    families = {str(s["name"]): str(s.get("family", s["name"])) for s in run.meta["scenarios"]}
    values["draw"] = [f"{families.get(name, name)}/{seed}" for name, seed in values.index]
    return values


def _capped(values: Floats, cap: float) -> Floats:
    """Limit values to a cap, which NaN and infinite values count as."""
    return np.where(np.isfinite(values), np.minimum(values, cap), cap)


def check_comparable(base: SavedRun, new: SavedRun) -> None:
    """Raise NotComparable unless both runs played the same episodes to their end."""
    for run in (base, new):
        if not run.meta["complete"]:
            raise NotComparable(f"{run.folder}: was interrupted; play it to its end first")
    _check_versions(base, new)
    _check_suites(base, new)
    here, there = _per_episode(new, "digests"), _per_episode(base, "digests")
    for one, other, run in ((here, there, base), (there, here, new)):
        absent = sorted(set(one) - set(other))
        if absent:
            name, seed = absent[0]
            raise NotComparable(
                f"{run.folder}: lacks {len(absent)} of {len(one)} episodes of the other run, the "
                f"first: {name} seed {seed}; play both with the same suite and --seeds"
            )
    changed = sorted(key for key in here if here[key] != there[key])
    if changed:
        name, seed = changed[0]
        raise NotComparable(
            f"{len(changed)} of {len(here)} episodes are not the same (digests), the first: "
            f"{name} seed {seed}; its scenario, or what was set of it, has changed since the base"
        )
    ours, theirs = _per_episode(new, "truths"), _per_episode(base, "truths")
    # An episode without a result has no truth to be compared.
    moved = sorted(
        k for k in ours if ours[k] and theirs.get(k) and not same_motion(ours[k], theirs[k])
    )
    if moved:
        name, seed = moved[0]
        raise NotComparable(
            f"{len(moved)} of {len(here)} episodes moved differently, the first: {name} seed "
            f"{seed}; the simulator has changed since the base: play the base again with this one"
        )


def _check_versions(base: SavedRun, new: SavedRun) -> None:
    ours, theirs = (run.meta.get("metrics_version") for run in (new, base))
    if ours != theirs:
        raise NotComparable(
            f"metrics version {theirs} in {base.folder} and {ours} in {new.folder}: "
            f"play the base again with this version"
        )


def _check_suites(base: SavedRun, new: SavedRun) -> None:
    ours, theirs = suites_of(new), suites_of(base)
    if ours and theirs and set(ours) != set(theirs):
        raise NotComparable(
            f"{base.folder} is of {', '.join(sorted(theirs))} and {new.folder} of "
            f"{', '.join(sorted(ours))}; play the base again with this version"
        )
    for name in sorted(set(ours) & set(theirs)):
        if ours[name] != theirs[name]:
            raise NotComparable(
                f"{name} is not the same in both runs (digests): one was played with changed "
                f"scenarios; play the base again with this version"
            )


def suites_of(run: SavedRun) -> dict[str, str]:
    """name@version -> digest of the suites that a run played."""
    return {f"{s['name']}@{s['version']}": str(s["digest"]) for s in run.meta.get("suites", ())}


def _per_episode(run: SavedRun, key: str) -> dict[Episode, str]:
    """Map (scenario, seed) to its entry in a list of run.json; empty where run.json lacks it."""
    return {
        (str(scenario["name"]), int(seed)): str(entry)
        for scenario in run.meta["scenarios"]
        if key in scenario
        for seed, entry in zip(scenario["seeds"], scenario[key], strict=True)
    }


def notes_of(base: SavedRun, new: SavedRun) -> tuple[str, ...]:
    """Other differences between two comparable runs, which are part of their result."""
    here, there = new.meta["provenance"], base.meta["provenance"]
    notes = []
    if base.folder.resolve() == new.folder.resolve():
        notes.append(f"{new.folder} was compared with itself")
    if here.get("renderer") != there.get("renderer"):
        notes.append(
            f"rendered by {here.get('renderer') or 'unknown'}, the base by "
            f"{there.get('renderer') or 'unknown'}: pixels may differ"
        )
    ours, theirs = here.get("versions", {}), there.get("versions", {})
    changed = [name for name in sorted(ours) if name in theirs and ours[name] != theirs[name]]
    if changed:
        notes.append(
            "other versions than in the base: "
            + ", ".join(f"{name} {theirs[name]} -> {ours[name]}" for name in changed)
        )
    return tuple(notes)


def same_results(base: SavedRun, new: SavedRun) -> bool:
    """Whether the results of two runs are the same, bit for bit.

    Frames are compared where both runs have them: a slim run keeps only their sums; columns where
    both have them: a run of an earlier version lacks some.
    """
    names = ["events", "tracking", "episodes"]
    if len(base.frames) and len(new.frames):
        names.append("frames")
    oldest = min(base.version, new.version)
    pairs = [(_measured(base, name, oldest), _measured(new, name, oldest)) for name in names]
    return all(one.equals(other) for one, other in pairs)


def _measured(run: SavedRun, name: str, version: int) -> pd.DataFrame:
    """A table with the columns of a version, without those that a slim run leaves out."""
    table: pd.DataFrame = getattr(run, name)
    if name == "episodes":
        return measured(table, version)
    return table.drop(columns=list(columns_since(version, name)))


def measured(episodes: pd.DataFrame, version: int) -> pd.DataFrame:
    """The table of episodes as of a version, without the columns that a slim run leaves out."""
    return episodes.drop(columns=["digest", "values_json", *columns_since(version, "episodes")])


def joined(runs: Sequence[SavedRun]) -> SavedRun:
    """Join runs of different seeds of the same scenarios; all else is the first run's."""
    first = runs[0]
    lists = ("seeds", "digests", "truths", "failures")
    scenarios = [
        {**one, **{key: list(_chained(runs, str(one["name"]), key)) for key in lists if key in one}}
        for one in first.meta["scenarios"]
    ]
    tables: dict[str, pd.DataFrame] = {}
    for name in ("episodes", "events", "tracking"):
        whole = pd.concat([getattr(run, name) for run in runs], ignore_index=True)
        tables[name] = whole.sort_values(KEY, kind="stable", ignore_index=True)
    # A verdict needs no frames.
    meta = {**first.meta, "scenarios": scenarios}
    return replace(first, meta=meta, frames=first.frames.iloc[:0], **tables)


def _chained(runs: Sequence[SavedRun], name: str, key: str) -> Iterator[Any]:
    for run in runs:
        for scenario in run.meta["scenarios"]:
            if scenario["name"] == name:
                yield from scenario[key]
