"""The ranking of episodes by failure, for the page's gallery and the kept films."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

MAX_WORST = 12


def badness(rows: Sequence[Mapping[str, Any]]) -> tuple[float, float]:
    """Badness of an episode from its rows of the table of episodes, a target each; more is worse.

    First the share of target-frames that are not within 100 mm, then the mean error [mm] of the
    others. (0, 0) for an episode without a result.
    """
    frames = sum(int(row["frames"]) for row in rows)
    if not frames:
        return 0.0, 0.0
    measured = sum(int(row["n_error_mm"]) for row in rows)
    mean_mm = sum(float(row["sum_error_mm"]) for row in rows) / measured if measured else 0.0
    return 1.0 - sum(int(row["within_100"]) for row in rows) / frames, mean_mm


def went_wrong(rows: Sequence[Mapping[str, Any]]) -> bool:
    """A swap, a capture, a loss, or more than one target-frame in twenty not within 100 mm."""
    failed = any(row["ever_swapped"] or row["ever_captured"] or row["ever_lost"] for row in rows)
    return failed or badness(rows)[0] > 0.05


# (0, -share outside, -mean mm, scenario, seed) of what went wrong, else (1, seed, scenario).
FilmRank = tuple[int, float, float, str, int] | tuple[int, int, str]


def film_rank(key: tuple[str, int], rows: Sequence[Mapping[str, Any]]) -> FilmRank:
    """The place of an episode (scenario, seed) in the order of films; smaller comes first.

    First those that went wrong, the worst first; then the others by seed, so that every scenario
    has one before any has two. It depends on the episode alone. rows: as of `badness`.
    """
    scenario, seed = key
    if not went_wrong(rows):
        return 1, seed, scenario
    outside, mean_mm = badness(rows)
    return 0, -outside, -mean_mm, scenario, seed
