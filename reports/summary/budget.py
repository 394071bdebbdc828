"""The error budget of a run: mean errors, each level with one more cause of error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from pjpdaf.targets import TARGETS
from reports.run.load import SavedRun
from reports.score.records import BUDGET_LEVELS

# The cause of error that a level adds to the level before.
CAUSES = {
    "grid": "whole pixels",
    "surface": "visible skin, not the body's centre",
    "detector": "detector",
    "filter": "filter",
    "association": "association",
}


@dataclass(frozen=True)
class Budget:
    """Mean error [mm] of each of `BUDGET_LEVELS` and target; frames: how many, by target."""

    levels_mm: Mapping[str, Mapping[str, float]]
    frames: Mapping[str, int]

    @property
    def shares_mm(self) -> dict[str, dict[str, float]]:
        """The error that each cause adds [mm], by target: the first level, then differences."""
        names = list(self.levels_mm)
        first = {CAUSES[names[0]]: dict(self.levels_mm[names[0]])}
        return first | {
            CAUSES[after]: {
                target: value - self.levels_mm[before][target]
                for target, value in self.levels_mm[after].items()
            }
            for before, after in pairwise(names)
        }


def budget_of(run: SavedRun) -> Budget | None:
    """The budget over all episodes of a run, None where none was made."""
    counted = {t: run.episodes[run.episodes["target"] == t] for t in TARGETS}
    frames = {t: int(rows["budget_frames"].sum()) for t, rows in counted.items()}
    if not all(frames.values()):
        return None
    levels = {
        level: {
            t: float(rows[f"sum_budget_{level}_mm"].sum()) / frames[t]
            for t, rows in counted.items()
        }
        for level in BUDGET_LEVELS
    }
    return Budget(levels, frames)
