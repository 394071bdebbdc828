"""The episodes of a saved run that gave no result."""

from __future__ import annotations

from typing import cast, get_args

from reports.run.load import SavedRun
from reports.score.records import EpisodeFailure, FailureKind


def failures_of(run: SavedRun) -> list[EpisodeFailure]:
    """The failures in run.json, scenario by scenario."""
    return [
        EpisodeFailure(
            scenario=str(scenario["name"]),
            seed=int(failure["seed"]),
            reason=str(failure["reason"]),
            kind=_kind(failure.get("kind"), str(failure["reason"])),
            group=str(scenario.get("group", "")),
        )
        for scenario in run.meta["scenarios"]
        for failure in scenario.get("failures", ())
    ]


def _kind(stored: object, reason: str) -> FailureKind:
    """The stored kind; of an older run, which has none, the kind that its text belongs to."""
    if stored in get_args(FailureKind):
        return cast(FailureKind, stored)
    return "unposable" if reason.startswith("cannot be posed") else "exception"
