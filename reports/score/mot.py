"""Multi-object tracking scores as the field expects them: CLEAR MOT, identity, HOTA.

They ask whether *some* track follows a target, not whether the right one does: a tracker that has
the hands swapped from the first frame on is perfect by MOTA and IDF1. Our own scores (`score`,
`events`) do not forget names; these are for comparison with other people's figures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from pjpdaf.arrays import Floats
from reports.score.assignment import assignment
from reports.score.score import Bools

MATCH_M = 0.15  # a track farther from a target than this does not follow it
ALPHAS = np.arange(0.05, 0.99, 0.05)  # localisation thresholds of HOTA
EPS = float(np.finfo("float").eps)


@dataclass(frozen=True)
class ClearCounts:
    """CLEAR MOT (Bernardin and Stiefelhagen 2008): counts, so that episodes can be summed."""

    truths: int = 0
    matches: int = 0  # switches included
    misses: int = 0
    false_positives: int = 0
    switches: int = 0
    sum_distance_m: float = 0.0

    @property
    def mota(self) -> float:
        """1 - (misses + false positives + switches) / truths; NaN without truths."""
        if not self.truths:
            return float("nan")
        wrong = self.misses + self.false_positives + self.switches
        return 1.0 - wrong / self.truths

    @property
    def motp_m(self) -> float:
        """Mean distance of the matches [m]; NaN without any."""
        return self.sum_distance_m / self.matches if self.matches else float("nan")


@dataclass(frozen=True)
class IdentityCounts:
    """Identity scores (Ristani et al. 2016) of the best one-to-one pairing of whole tracks."""

    true_positives: int = 0
    false_positives: int = 0
    false_negatives: int = 0

    @property
    def idf1(self) -> float:
        """2 IDTP / (2 IDTP + IDFP + IDFN); NaN where there is nothing to score."""
        whole = 2 * self.true_positives + self.false_positives + self.false_negatives
        return 2 * self.true_positives / whole if whole else float("nan")


@dataclass(frozen=True, eq=False)
class HotaCounts:
    """HOTA (Luiten et al. 2021) per threshold of `ALPHAS`, each (19,).

    association: the sum over true positives of the association score of their pair.
    """

    true_positives: Floats
    false_negatives: Floats
    false_positives: Floats
    association: Floats

    @property
    def detection_accuracy(self) -> Floats:
        """DetA (19,)."""
        whole = self.true_positives + self.false_negatives + self.false_positives
        return np.asarray(self.true_positives / np.maximum(1, whole))

    @property
    def association_accuracy(self) -> Floats:
        """AssA (19,)."""
        return np.asarray(self.association / np.maximum(1, self.true_positives))

    @property
    def hota(self) -> float:
        """Mean over the thresholds of sqrt(DetA AssA)."""
        return float(np.sqrt(self.detection_accuracy * self.association_accuracy).mean())


def summed_clear(parts: Sequence[ClearCounts]) -> ClearCounts:
    """Of several episodes together."""
    return ClearCounts(*(sum(getattr(p, f.name) for p in parts) for f in fields(ClearCounts)))


def summed_identity(parts: Sequence[IdentityCounts]) -> IdentityCounts:
    """Of several episodes together."""
    names = fields(IdentityCounts)
    return IdentityCounts(*(sum(getattr(p, f.name) for p in parts) for f in names))


def summed_hota(parts: Sequence[HotaCounts]) -> HotaCounts:
    """Of several episodes together: detections summed, association weighted by true positives."""
    none = np.zeros(len(ALPHAS))
    totals = (sum((getattr(p, f.name) for p in parts), none) for f in fields(HotaCounts))
    return HotaCounts(*(np.asarray(total) for total in totals))


def present(points_m: Floats) -> Bools:
    """Which points (..., 3) are there (...): all three numbers finite."""
    finite: Bools = np.asarray(np.isfinite(points_m).all(axis=-1))
    return finite


def distances(truths_m: Floats, estimates_m: Floats) -> Floats:
    """Distance (F, T, K) [m] of truths (F, T, 3) to estimates (F, K, 3), NaN without either."""
    return np.asarray(np.linalg.norm(truths_m[:, :, None] - estimates_m[:, None], axis=-1))


def clear_mot(truths_m: Floats, estimates_m: Floats, match_m: float = MATCH_M) -> ClearCounts:
    """CLEAR MOT counts of truths (F, T, 3) and tracks (F, K, 3), NaN where there is none.

    A pairing lasts while its distance is at most match_m; what is left is paired by least total
    distance. A target paired with another track than its last one, however long ago, is a switch.
    """
    targets, tracks = present(truths_m), present(estimates_m)
    between = distances(truths_m, estimates_m)
    allowed: Bools = np.asarray(np.nan_to_num(between, nan=np.inf) <= match_m)
    last: dict[int, int] = {}
    matches = switches = 0
    total = 0.0
    for frame in range(len(truths_m)):
        open_ = allowed[frame].copy()
        pairs = []
        for target in np.flatnonzero(targets[frame]).tolist():
            track = last.get(target, -1)
            if track >= 0 and open_[target, track]:
                pairs.append((target, track))
                open_[target], open_[:, track] = False, False
        pairs += _assigned(between[frame], open_)
        for target, track in pairs:
            switches += last.get(target, track) != track
            last[target] = track
            total += float(between[frame, target, track])
        matches += len(pairs)
    return ClearCounts(
        truths=int(targets.sum()),
        matches=matches,
        misses=int(targets.sum()) - matches,
        false_positives=int(tracks.sum()) - matches,
        switches=int(switches),
        sum_distance_m=total,
    )


def _assigned(cost: Floats, allowed: Bools) -> list[tuple[int, int]]:
    """As many allowed pairs as there can be, and of these choices the cheapest."""
    if not allowed.any():
        return []
    # Dearer than any number of allowed pairs.
    dear = 1.0 + float(cost[allowed].sum()) * 2 + float(cost[allowed].max()) * cost.size
    rows, columns = assignment(np.where(allowed, cost, dear))
    return [(int(r), int(c)) for r, c in zip(rows, columns, strict=True) if allowed[r, c]]


def identity(truths_m: Floats, estimates_m: Floats, match_m: float = MATCH_M) -> IdentityCounts:
    """Identity counts of truths (F, T, 3) and tracks (F, K, 3), NaN where there is none."""
    targets, tracks = present(truths_m), present(estimates_m)
    near = np.nan_to_num(distances(truths_m, estimates_m), nan=np.inf) <= match_m
    together = near.sum(axis=0)  # (T, K): frames in which the pair is near
    rows, columns = assignment(-together)
    hits = int(together[rows, columns].sum())
    return IdentityCounts(hits, int(tracks.sum()) - hits, int(targets.sum()) - hits)


def hota(truths_m: Floats, estimates_m: Floats, zero_m: float = 2 * MATCH_M) -> HotaCounts:
    """HOTA counts of truths (F, T, 3) and tracks (F, K, 3), NaN where there is none.

    The similarity of a pair is 1 - distance / zero_m, at least 0.
    """
    targets, tracks = present(truths_m), present(estimates_m)
    far = np.nan_to_num(distances(truths_m, estimates_m), nan=np.inf)
    similarity = np.maximum(0.0, 1.0 - far / zero_m)
    sums = similarity.sum(axis=1, keepdims=True) + similarity.sum(axis=2, keepdims=True)
    union = sums - similarity
    share = np.where(union > EPS, similarity / np.where(union > EPS, union, 1.0), 0.0)
    potential = share.sum(axis=0)
    length = targets.sum(axis=0)[:, None] + tracks.sum(axis=0)[None]
    overall = potential / np.maximum(length - potential, EPS)
    together = np.zeros((len(ALPHAS), *potential.shape))
    for frame, similar in enumerate(similarity):
        rows_in, columns_in = np.flatnonzero(targets[frame]), np.flatnonzero(tracks[frame])
        if not len(rows_in) or not len(columns_in):
            continue
        place = np.ix_(rows_in, columns_in)
        rows, columns = assignment(-(overall * similar)[place])
        rows, columns = rows_in[rows], columns_in[columns]
        hit = similar[rows, columns] >= ALPHAS[:, None] - EPS
        together[:, rows, columns] += hit
    hits = together.sum(axis=(1, 2))
    pair = together / np.maximum(1, length - together)
    return HotaCounts(
        true_positives=hits,
        false_negatives=targets.sum() - hits,
        false_positives=tracks.sum() - hits,
        association=np.asarray((together * pair).sum(axis=(1, 2))),
    )
