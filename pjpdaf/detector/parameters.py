"""All parameters of the detector: the records of its stages."""

from __future__ import annotations

from dataclasses import dataclass, field

from pjpdaf.checks import AboveZero, check_bounds
from pjpdaf.detector.background import BackgroundParameters
from pjpdaf.detector.clusters import ClusterParameters
from pjpdaf.detector.components import ComponentParameters
from pjpdaf.detector.skin import SkinRange
from pjpdaf.detector.undistortion import Undistortion, UndistortPoints


@dataclass(frozen=True)
class DetectorParameters:
    """Thesis 3.1: skin, background, components, clusters."""

    undistort: Undistortion = field(default_factory=UndistortPoints)
    skin: SkinRange = field(default_factory=SkinRange)
    background: BackgroundParameters = field(default_factory=BackgroundParameters)
    components: ComponentParameters = field(default_factory=ComponentParameters)
    clusters: ClusterParameters = field(default_factory=ClusterParameters)
    # Standard deviation of a centre, per axis [px], reported with each detection; R of Table 4.1
    # is 15 px^2.
    centre_sd_px: AboveZero = 15.0**0.5

    def __post_init__(self) -> None:
        check_bounds("DetectorParameters", self)
