"""Exchange probabilities against what was: frames with the hands exchanged, and reliability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from reports.score.events import hands_apart, swap_margin
from reports.score.records import Episode

# Of the bins of stated probabilities: most are near 0, and doubt is what they are for.
EDGES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class Exchange:
    """Stated probability and outcome of F frames.

    stated (F,): NaN where the tracker gives none; exchanged (F,): 1 where the hands' estimates are
    exchanged, 0 where not, NaN where that is undefined.
    """

    stated: Floats
    exchanged: Floats

    @property
    def judged(self) -> Exchange:
        """The frames that have both."""
        both = np.isfinite(self.stated) & np.isfinite(self.exchanged)
        return Exchange(self.stated[both], self.exchanged[both])


def exchange_of(episode: Episode) -> Exchange:
    """The exchange of each frame of an episode."""
    truths = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    stated = np.array([outcome.estimates.exchange_probability for outcome in episode.frames])
    return Exchange(stated, exchanged(truths, estimates))


def exchanged(truths_m: Floats, estimates_m: Floats) -> Floats:
    """1 (F,) where the swap margin of positions (F, T, 3) is negative, else 0.

    NaN where the hands are within 0.10 m of each other, or one has no estimate.
    """
    margin = swap_margin(truths_m, estimates_m)
    defined = hands_apart(truths_m) & np.isfinite(margin)
    return np.where(defined, (margin < 0).astype(np.float64), np.nan)


@dataclass(frozen=True)
class ReliabilityBin:
    """Frames whose stated probability is in [low, high), the last bin with its end.

    frames: how many; stated: mean of theirs; observed: share of them that is exchanged.
    """

    low: float
    high: float
    frames: int
    stated: float
    observed: float


def reliability(exchange: Exchange, edges: Sequence[float] = EDGES) -> tuple[ReliabilityBin, ...]:
    """The bins that have frames."""
    judged = exchange.judged
    place = np.clip(np.searchsorted(edges, judged.stated, side="right") - 1, 0, len(edges) - 2)
    bins = []
    for k in np.unique(place).tolist():
        mine = place == k
        stated, observed = judged.stated[mine].mean(), judged.exchanged[mine].mean()
        bins.append(
            ReliabilityBin(edges[k], edges[k + 1], int(mine.sum()), float(stated), float(observed))
        )
    return tuple(bins)


def calibration_error(bins: Sequence[ReliabilityBin]) -> float:
    """Expected calibration error: mean |stated - observed| over the frames; NaN without any."""
    frames = sum(b.frames for b in bins)
    off = sum(b.frames * abs(b.stated - b.observed) for b in bins)
    return off / frames if frames else float("nan")
