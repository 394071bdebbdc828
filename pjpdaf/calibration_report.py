"""Records of a calibration: its quality, and the use of each pair of pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.boards import Board
from pjpdaf.camera import StereoRig


@dataclass(frozen=True)
class PairReport:
    """Use of a pair of pictures: its part in the calibration, or the reason why it was left out.

    used, and if not its reason; turned: the right board was numbered from the other end; errors:
    root mean square reprojection error of the final rig in each view [px], NaN if not used.
    """

    left: str
    right: str
    used: bool
    reason: str = ""
    turned: bool = False
    error_left_px: float = float("nan")
    error_right_px: float = float("nan")


@dataclass(frozen=True, eq=False)
class CalibrationReport:
    """A calibration and its quality.

    rig: left camera at the origin; pairs: every pair, in order; rms_left_px, rms_right_px: each
    camera alone; rms_stereo_px: the final rig; epipolar_px: mean |y_left - y_right| of the corners
    after rectification. sd_left, sd_right (4 + n,): standard deviations of fx fy cx cy [px] and
    of the lens's coefficients; files: those that were written.
    """

    board: Board
    rig: StereoRig
    pairs: tuple[PairReport, ...]
    rms_left_px: float
    rms_right_px: float
    rms_stereo_px: float
    epipolar_px: float
    sd_left: Floats
    sd_right: Floats
    files: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        for name in ("sd_left", "sd_right"):
            value = readonly(getattr(self, name), (None,), f"CalibrationReport.{name}")
            object.__setattr__(self, name, value)

    @property
    def used(self) -> int:
        """Number of pairs that the calibration rests on."""
        return sum(pair.used for pair in self.pairs)

    @property
    def baseline_m(self) -> float:
        """Distance between the cameras [m]."""
        return float(np.linalg.norm(self.rig.T))
