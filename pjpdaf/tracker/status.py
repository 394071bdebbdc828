"""Status of the targets after a step: tracked, coasting or lost. Ours; not in the thesis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.checks import AboveZero, NotNegative, check_bounds
from pjpdaf.tracker.association import Association
from pjpdaf.tracker.state import TrackState


@dataclass(frozen=True)
class StatusParameters:
    """Limits beyond which a target is lost."""

    # Time without being located in two views [s].
    lost_after_s: NotNegative = 1.0
    # Standard deviation of the position along its worst axis [m].
    lost_sd_m: AboveZero = 0.5

    def __post_init__(self) -> None:
        check_bounds("TrackerParameters", self)


def judge(
    parameters: StatusParameters,
    before: TrackState,
    mean: Floats,
    covariance: Floats,
    association: Association,
    dt_s: float,
) -> TrackState:
    """Return the state after a step, with clock and status of each target.

    mean (T, 6), covariance (T, 6, 6) after the update. tracked: located in two views (one, if there
    is only one) in which no occlusion rule holds; lost: over its time or too uncertain.
    """
    seen, beta_0 = association, association.beta_0
    claimed = seen.present & (1.0 - beta_0 >= seen.found_mass)
    needed = min(2, beta_0.shape[1])
    located = (claimed & ~seen.merged).sum(axis=1) >= needed
    # A target inside a merged blob is not lost, only not located: its clock stands still.
    inside = (claimed | seen.merged & seen.present).sum(axis=1) >= needed
    unseen_s = np.where(located, 0.0, before.unseen_s + np.where(inside, 0.0, dt_s))
    P = covariance[:, :3, :3]
    trace = P[:, 0, 0] + P[:, 1, 1] + P[:, 2, 2]
    wide = trace > parameters.lost_sd_m**2  # no eigenvalue exceeds it
    if wide.any():
        wide = np.linalg.eigvalsh(P)[:, -1] > parameters.lost_sd_m**2
    # 1e-9: three steps of 1/3 s are 1 s.
    lost = wide | (unseen_s >= parameters.lost_after_s - 1e-9) & ~located
    status = tuple(
        "lost" if gone else "tracked" if here else "coasting"
        for gone, here in zip(lost.tolist(), located.tolist(), strict=True)
    )
    return TrackState(mean, covariance, unseen_s, status)
