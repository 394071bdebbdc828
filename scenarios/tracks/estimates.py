"""Estimates from tracks, and signs that their unit or frame is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import Estimates
from pjpdaf.targets import TARGETS
from scenarios.tracks.tracks import LOST, Tracks
from sim.dataset.stored_sequence import StoredSequence

FRAMES = ("world", "left")
FAR_M = 50.0  # median distance from the cameras; above it, positions are not in metres
MOVING_M = 0.03  # a frame; slower, a shift makes little difference
LEAST_MOVING = 6  # positions of targets that move so
NEARER = 0.6
NOTABLE_M = 0.1  # median error that may come from the wrong --frame


def estimates_of(tracks: Tracks, camera: Camera, frame: str) -> list[Estimates]:
    """Make the estimates of each frame, in the data set's world.

    camera: the left one of the calibration, in whose frame the positions are where frame is "left".
    Deviations become a covariance without correlations.
    """
    positions = tracks.positions_m
    covariances = np.full((*positions.shape, 3), np.nan)
    known = np.isfinite(tracks.sd_m).all(axis=-1)
    covariances[known] = tracks.sd_m[known][:, :, None] ** 2 * np.eye(3)
    if frame == "left":
        R = camera.R_cw.T
        positions = (positions - camera.t_cw) @ R.T
        covariances = R @ covariances @ R.T
    unknown = np.full((len(TARGETS), 3), np.nan)
    return [
        Estimates(position, covariance, unknown, status, float(exchange))
        for position, covariance, status, exchange in zip(
            positions, covariances, tracks.status, tracks.exchange_probability, strict=True
        )
    ]


def lost_estimates() -> Estimates:
    """Estimates of a frame in which all targets are lost."""
    waiting = Estimates.waiting(len(TARGETS))
    return Estimates(
        waiting.positions_m,
        waiting.covariances_m2,
        waiting.velocities_mps,
        (LOST,) * len(TARGETS),
    )


def check_metres(tracks: Tracks, estimates: list[Estimates], camera: Camera) -> None:
    """Raise BenchError for positions so far from the camera that they are not in metres."""
    far = np.linalg.norm(_positions(estimates) - camera.centre_w, axis=-1)
    median = float(np.nanmedian(far)) if np.isfinite(far).any() else 0.0
    if median > FAR_M:
        raise BenchError(
            f"{tracks.path}: the positions are {median:.0f} m from the cameras (median); metres "
            "are expected, not mm"
        )


def much_nearer(sequence: StoredSequence, given: list[Estimates], other: list[Estimates]) -> bool:
    """Whether the estimates `other` are so much nearer to the truth that they are likely meant."""
    centres = np.stack([truth.centres_m for truth in sequence.truths])
    errors = [
        np.linalg.norm(_positions(estimates) - centres, axis=-1) for estimates in (given, other)
    ]
    if not np.isfinite(errors[0]).any():
        return False
    now, then = (float(np.nanmedian(error)) for error in errors)
    return now > NOTABLE_M and then < now / 2


@dataclass(frozen=True)
class FrameShift:
    """Tracks that fit the truth of other frames much better than that of their own.

    frames: their frame number plus this is the truth's that fits; now_mm, then_mm: median error
    where targets move, as the frames are numbered and with the shift.
    """

    frames: int
    now_mm: float
    then_mm: float


def frame_shift(sequence: StoredSequence, estimates: list[Estimates]) -> FrameShift | None:
    """The shift by one frame with which tracks would be much nearer; None without any.

    Frames counted from 1, or a picture lost at the start, look like a tracker that is late.
    """
    centres = np.stack([truth.centres_m for truth in sequence.truths])
    positions = _positions(estimates)
    if len(centres) < LEAST_MOVING + 2:
        return None
    inner = slice(1, -1)  # frames that have a neighbour on both sides
    moved = np.linalg.norm(centres[2:] - centres[:-2], axis=-1) / 2.0
    errors = {
        shift: np.linalg.norm(
            positions[inner] - centres[1 + shift : len(centres) - 1 + shift], axis=-1
        )
        for shift in (-1, 0, 1)
    }
    used = (moved > MOVING_M) & np.isfinite(errors[0])
    if used.sum() < LEAST_MOVING:
        return None
    medians = {shift: 1000.0 * float(np.median(error[used])) for shift, error in errors.items()}
    best = min(medians, key=lambda shift: medians[shift])
    if best == 0 or medians[best] > NEARER * medians[0] or medians[0] - medians[best] < 10.0:
        return None
    return FrameShift(best, medians[0], medians[best])


def _positions(estimates: list[Estimates]) -> Floats:
    return np.stack([frame.positions_m for frame in estimates])
