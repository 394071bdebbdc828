"""Process model of the targets (thesis 3.2): constant velocity and its noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.checks import AboveZero, NotNegative, check_bounds
from pjpdaf.tracker.thesis_units import FRAME_S, MM2, MM2_PER_FRAME2


class NoiseGrowth(Protocol):
    """Dependence of Q on the time step."""

    def frames(self, dt_s: float, frame_s: float) -> float:
        """Multiple of the printed Q for a step of dt_s; frame_s: one frame of the thesis."""
        ...


@final
@dataclass(frozen=True)
class PerFrame:
    """The printed Q for any time step."""

    def frames(self, dt_s: float, frame_s: float) -> float:
        """Return 1."""
        return 1.0


@final
@dataclass(frozen=True)
class Scaled:
    """Q dt / frame_s: a random walk's variance grows with time."""

    def frames(self, dt_s: float, frame_s: float) -> float:
        """Return the number of thesis frames in dt_s."""
        return dt_s / frame_s


NOISE_GROWTHS: Mapping[str, NoiseGrowth] = {"per_frame": PerFrame(), "scaled": Scaled()}


@dataclass(frozen=True)
class ProcessParameters:
    """Prediction: x' = F x, P' = F P F^T + Q (Eq. 3.7-3.8, 3.35-3.36)."""

    process: NoiseGrowth = field(default_factory=Scaled)
    # One frame, the unit of time of the thesis's velocities and of Q [s]; 3 frames/s, section 4.1.
    frame_s: AboveZero = FRAME_S
    # Q = diag(q q q v v v) of Eq. 3.5, Table 4.1, a frame: q = 50 mm^2 [m^2] ...
    process_position_m2: NotNegative = 50 * MM2
    # ... and v = 5 (mm/frame)^2 [(m/s)^2].
    process_velocity_m2ps2: NotNegative = 5 * MM2_PER_FRAME2

    def __post_init__(self) -> None:
        check_bounds("TrackerParameters", self)


def transition(dt_s: float) -> Floats:
    """F of Eq. 3.3, constant velocity, (6, 6)."""
    F = np.eye(6)
    F[[0, 1, 2], [3, 4, 5]] = dt_s
    return F


def process_noise(parameters: ProcessParameters, dt_s: float) -> Floats:
    """Q of Eq. 3.5 for a step of dt_s, (6, 6) [m^2, m^2/s^2]."""
    frames = parameters.process.frames(dt_s, parameters.frame_s)
    position, velocity = parameters.process_position_m2, parameters.process_velocity_m2ps2
    return np.asarray(np.diag([position] * 3 + [velocity] * 3) * frames)
