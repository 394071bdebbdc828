"""Robustness of an episode: how far it was from a swap, a swap with the head, or a loss.

Negative means failure. Every measure is negative exactly where the event of the same frames is
found (`reports.score.events`), so that a search can follow a number where the score counts events.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND, TARGETS
from reports.score.events import APART_M, LOST_M, LOST_S, SWAP_S, frames_of, pair_margin
from reports.score.records import Episode
from reports.score.score import Bools

Goal = Literal["swap", "head", "lost"]
GOALS: tuple[Goal, ...] = get_args(Goal)
# The measures in their order, each with the targets that it is about.
PAIRS = {
    "swap": (RIGHT_HAND, LEFT_HAND),
    "head_right": (HEAD, RIGHT_HAND),
    "head_left": (HEAD, LEFT_HAND),
}
LOSSES = {"lost_head": HEAD, "lost_right": RIGHT_HAND, "lost_left": LEFT_HAND}
MEASURES = (*PAIRS, *LOSSES)
NEAR_M = 0.2  # estimates nearer to each other than this make a swap likely
MOST_ERROR_M = 1.0  # greater distances are no worse, and no estimate is as bad as this


@dataclass(frozen=True)
class Robustness:
    """Robustness of an episode, negative where it failed.

    swap, head_right, head_left: of the hands, of the head with a hand: rho, +1 right, -1 swapped;
    +1 where the two are never apart. lost: of each target (gate - least error) / gate.
    coalescence_m: least distance of the two estimates of each pair of `PAIRS`, 1 m at most.
    ends: for each of `MEASURES` the last frame of its first failing window, -1 where none fails.
    """

    swap: float
    head_right: float
    head_left: float
    lost: tuple[float, float, float]
    coalescence_m: tuple[float, float, float]
    ends: tuple[int, ...]

    @property
    def measures(self) -> dict[str, float]:
        """rho of each of `MEASURES`."""
        values = (self.swap, self.head_right, self.head_left, *self.lost)
        return dict(zip(MEASURES, values, strict=True))

    @property
    def worst(self) -> float:
        """The least rho."""
        return min(self.measures.values())

    @property
    def failed(self) -> tuple[str, ...]:
        """The measures below 0, in the order of `MEASURES`."""
        return tuple(name for name, rho in self.measures.items() if rho < 0)

    def objective(self, goal: Goal) -> float:
        """J, which a search makes small: clip(rho, -1, 1) + min(1, c / 0.2 m), c the coalescence.

        rho alone is a cliff; c leads to it. A loss has a slope of its own: clip(rho, -1, 1).
        """
        if goal == "lost":
            return float(np.clip(min(self.lost), -1.0, 1.0))
        of_pairs = [
            float(np.clip(rho, -1.0, 1.0)) + min(1.0, c / NEAR_M)
            for rho, c in zip(
                (self.swap, self.head_right, self.head_left), self.coalescence_m, strict=True
            )
        ]
        return of_pairs[0] if goal == "swap" else min(of_pairs[1:])


def measures_of(goals: Sequence[Goal]) -> tuple[str, ...]:
    """The measures that decide whether one of these goals is reached."""
    names = {"swap": ("swap",), "head": ("head_right", "head_left"), "lost": tuple(LOSSES)}
    return tuple(name for name in MEASURES if any(name in names[goal] for goal in goals))


def robustness(episode: Episode) -> Robustness:
    """The robustness of an episode (`robustness_of`)."""
    truths = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    return robustness_of(truths, estimates, episode.fps)


def robustness_of(truths_m: Floats, estimates_m: Floats, fps: float) -> Robustness:
    """The robustness of true and estimated positions (F, T, 3) [m], NaN where there is none.

    Of a pair a, b: m = <e_a - e_b, g_a - g_b> / |g_a - g_b|²; rho is the least, over windows of
    0.5 s of frames in which the two are more than 0.10 m apart, of the greatest m in the window.
    Frames without estimates, or with the two nearer, are passed over, at most as many together as a
    window has. Of a target: the least, over windows of 1 s, of (0.15 m - least error) / 0.15 m.
    """
    pairs = [_pair(truths_m, estimates_m, a, b, fps) for a, b in PAIRS.values()]
    losses = [_loss(truths_m[:, t], estimates_m[:, t], fps) for t in range(len(TARGETS))]
    swap, head_right, head_left = (rho for rho, _ in pairs)
    head, right, left = (rho for rho, _ in losses)
    hands, with_right, with_left = (_nearest(estimates_m, a, b) for a, b in PAIRS.values())
    return Robustness(
        swap,
        head_right,
        head_left,
        (head, right, left),
        (hands, with_right, with_left),
        tuple(end for _, end in (*pairs, *losses)),
    )


def _pair(truths: Floats, estimates: Floats, a: int, b: int, fps: float) -> tuple[float, int]:
    """rho of a pair, and the last frame of its first failing window."""
    margin = pair_margin(truths, estimates, a, b)
    apart = np.linalg.norm(truths[:, a] - truths[:, b], axis=1) > APART_M
    counted: Bools = apart & np.isfinite(margin)
    need = frames_of(SWAP_S, fps)
    rho, end = 1.0, -1
    window: list[tuple[int, float]] = []
    for frame in np.flatnonzero(counted).tolist():
        if window and frame - window[-1][0] - 1 > need:
            window = []  # too long a silence, as in `reports.score.events.sustained`
        window = [*window, (frame, float(margin[frame]))][-need:]
        if len(window) == need:
            most = max(m for _, m in window)
            rho = min(rho, most)
            end = frame if most < 0 and end < 0 else end
    return rho, end


def _loss(truths: Floats, estimates: Floats, fps: float) -> tuple[float, int]:
    """rho of a loss of a target (F, 3), and the last frame of its first failing window."""
    errors = np.linalg.norm(estimates - truths, axis=1)
    given = np.isfinite(errors)
    errors = np.minimum(np.where(given, errors, MOST_ERROR_M), MOST_ERROR_M)
    if given.any():
        errors[: int(np.argmax(given))] = 0.0  # it waits for a good start
    need = min(frames_of(LOST_S, fps), len(errors))
    least = np.lib.stride_tricks.sliding_window_view(errors, need).min(axis=1)
    rho = (LOST_M - least) / LOST_M
    failing = np.flatnonzero(rho < 0)
    return float(rho.min()), int(failing[0]) + need - 1 if len(failing) else -1


def _nearest(estimates: Floats, a: int, b: int) -> float:
    """Least distance of two estimates over the frames, `MOST_ERROR_M` at most."""
    distances = np.linalg.norm(estimates[:, a] - estimates[:, b], axis=1)
    given = distances[np.isfinite(distances)]
    return float(min([MOST_ERROR_M, *given.tolist()]))
