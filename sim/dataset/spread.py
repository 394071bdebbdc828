"""The spread of a data set: how evenly its labels fill their ranges, against a uniform spread."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from sim.dataset.reader import Dataset
from sim.dataset.statistics import HANDS, recipe_value
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

BINS = 1000  # of a range, in which values are counted: all results are exact to this


@dataclass(frozen=True)
class Quantity:
    """A quantity with the range that a data set ought to fill; log: evenly in its logarithm."""

    title: str
    unit: str
    low: float
    high: float
    log: bool = False

    def shares(self, values: Floats) -> Floats:
        """Where values lie in the range: 0 at its low end, 1 at its high end."""
        low, high = self.low, self.high
        if self.log:
            low, high = math.log(low), math.log(high)
            values = np.log(np.maximum(values, 1e-9))
        return np.asarray((values - low) / (high - low))

    def value_at(self, share: float) -> float:
        """The value at a share of the range."""
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)


# The ranges of the scenario catalogue; of shares all that is possible.
QUANTITIES: Mapping[str, Quantity] = {
    "rig_distance": Quantity("Cameras ahead of the shoulders, per sequence", "m", 1.1, 1.7),
    "distance": Quantity("Distance of a target from the left camera", "m", 0.6, 1.8),
    "skin_tone": Quantity("Skin tone, ITA, per sequence", "deg", -50.0, 60.0),
    "hand_speed": Quantity("Speed of a hand", "m/s", 0.02, 4.0, log=True),
    "truncation": Quantity("Share of a target outside the picture", "", 0.0, 1.0),
    "hidden": Quantity("Hidden share of a target in the picture", "", 0.0, 1.0),
}


@dataclass(frozen=True)
class Spread:
    """The spread of a quantity over a data set.

    counts (BINS + 2): values below the range, in each of its BINS equal parts, and above it.
    """

    quantity: Quantity
    counts: tuple[int, ...]

    @property
    def number(self) -> int:
        """How many values there are."""
        return sum(self.counts)

    @property
    def tenths(self) -> tuple[float, ...]:
        """Share of the values in each tenth of the range; values beyond it are in no tenth."""
        inside = np.array(self.counts[1:-1]).reshape(10, -1).sum(axis=1)
        return tuple((inside / max(self.number, 1)).tolist())

    @property
    def distance(self) -> float:
        """Kolmogorov-Smirnov distance to the uniform distribution over the range: 0 even, 1 not."""
        if not self.number:
            return math.nan
        reached = np.cumsum(self.counts)[:-1] / self.number
        return float(np.abs(reached - np.linspace(0, 1, BINS + 1)).max())

    def quantile(self, share: float) -> float:
        """The value that this share of the values does not exceed; NaN without values."""
        if not self.number:
            return math.nan
        place = int(np.searchsorted(np.cumsum(self.counts), share * self.number))
        return self.quantity.value_at(min(max(place - 0.5, 0.0), float(BINS)) / BINS)


def spread_of(dataset: Dataset) -> dict[str, Spread]:
    """The spread of each of QUANTITIES over all finished sequences.

    Raises FileError for a damaged sequence.
    """
    totals = {name: np.zeros(BINS + 2, np.int64) for name in QUANTITIES}
    for sequence in dataset.sequences:
        for name, values in _values(sequence).items():
            totals[name] += _counted(QUANTITIES[name], values)
    return {name: Spread(QUANTITIES[name], tuple(n.tolist())) for name, n in totals.items()}


def _counted(quantity: Quantity, values: Floats) -> NDArray[np.int64]:
    shares = quantity.shares(values[np.isfinite(values)])
    # The last part includes the high end.
    place = np.where(shares == 1.0, BINS, np.floor(np.clip(shares, -1, 2) * BINS) + 1)
    return np.bincount(np.clip(place, 0, BINS + 1).astype(int), minlength=BINS + 2)


def _values(sequence: StoredSequence) -> dict[str, Floats]:
    """Values of each quantity in a sequence, in any order, NaN where undefined."""
    rows, camera_w = sequence.truth, sequence.rig.left.centre_w
    places = rows[["x_m", "y_m", "z_m"]].to_numpy(np.float64)
    speeds = rows[["vx_mps", "vy_mps", "vz_mps"]].to_numpy(np.float64)
    hands = rows["target"].isin([TARGETS[t] for t in HANDS]).to_numpy()
    hidden = []
    for view in CAMERAS:
        shown = rows[f"visible_fraction_{view}"].to_numpy(np.float64)
        inside = rows[f"amodal_{view}_px"].to_numpy(np.float64) > 0
        hidden.append(np.where(inside, 1.0 - shown, np.nan))
    cut = [rows[f"truncation_{view}"].to_numpy(np.float64) for view in CAMERAS]
    return {
        "rig_distance": np.array([recipe_value(sequence.recipe, "rig_distance")]),
        "distance": np.linalg.norm(places - camera_w, axis=1),
        "skin_tone": np.array([recipe_value(sequence.recipe, "skin_ita")]),
        "hand_speed": np.linalg.norm(speeds[hands], axis=1),
        "truncation": np.concatenate(cut),
        "hidden": np.concatenate(hidden),
    }
