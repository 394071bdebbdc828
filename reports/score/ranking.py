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


def worst_first(
    episodes: Mapping[tuple[str, int], Sequence[Mapping[str, Any]]],
) -> list[tuple[str, int]]:
    """(scenario, seed) of at most `MAX_WORST` episodes that went wrong, the worst first.

    episodes: the rows of each, by scenario and seed; ties are in order of these.
    """
    wrong = sorted(key for key, rows in episodes.items() if went_wrong(rows))
    order = sorted(wrong, key=lambda key: badness(episodes[key]), reverse=True)
    return order[:MAX_WORST]
