"""The rows of each episode of a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from reports.run.load import SavedRun

Key = tuple[str, int]  # scenario, seed


@dataclass(frozen=True, eq=False)
class EpisodeTables:
    """Rows of a run's tables that belong to one episode with a result.

    frames: F * T rows, targets in order within a frame.
    """

    scenario: str
    seed: int
    frames: pd.DataFrame
    events: pd.DataFrame
    detections: pd.DataFrame
    cameras: pd.DataFrame

    def column(self, name: str) -> np.ndarray:
        """A column of `frames` as (F, T)."""
        return np.asarray(self.frames[name]).reshape(-1, len(TARGETS))

    def points_mm(self, kind: str) -> Floats:
        """Positions of "truth" or "estimate", (F, T, 3) [mm]."""
        axes = [self.column(f"{kind}_{axis}_m") for axis in "xyz"]
        return np.asarray(1e3 * np.stack(axes, axis=-1).astype(np.float64))

    @property
    def index(self) -> np.ndarray:
        """Number of each frame (F,)."""
        numbers: np.ndarray = self.column("frame")[:, 0]
        return numbers


def episode_tables(run: SavedRun) -> Iterator[EpisodeTables]:
    """Yield the episodes of a run that have a result, in its order."""
    tables = [run.events, run.detections, run.cameras]
    parts = [dict(iter(table.groupby(["scenario", "seed"], sort=False))) for table in tables]
    for (scenario, seed), frames in run.frames.groupby(["scenario", "seed"], sort=False):
        rows = [
            part.get((scenario, seed), table.iloc[:0])
            for part, table in zip(parts, tables, strict=True)
        ]
        yield EpisodeTables(str(scenario), int(seed), frames, *rows)
