"""All parameters of the tracker: the records of its stages."""

from __future__ import annotations

from dataclasses import dataclass, field

from pjpdaf.checks import BadParameter
from pjpdaf.tracker.association import AssociationParameters
from pjpdaf.tracker.clutter import Density
from pjpdaf.tracker.fusion.registry import FusionParameters
from pjpdaf.tracker.measurement import MeasurementParameters
from pjpdaf.tracker.occlusion import FewerMeasurements, OcclusionRule
from pjpdaf.tracker.process import ProcessParameters
from pjpdaf.tracker.start import StartParameters
from pjpdaf.tracker.status import StatusParameters


@dataclass(frozen=True)
class TrackerParameters:
    """Thesis 3.2-3.6 and Table 4.1, plus a reading wherever the thesis leaves a choice.

    Raises BadParameter where two stages do not fit together.
    """

    start: StartParameters = field(default_factory=StartParameters)
    process: ProcessParameters = field(default_factory=ProcessParameters)
    measurement: MeasurementParameters = field(default_factory=MeasurementParameters)
    association: AssociationParameters = field(default_factory=AssociationParameters)
    # Eq. 3.23: views that are left out for a target.
    occlusion: OcclusionRule = field(default_factory=FewerMeasurements)
    fusion: FusionParameters = field(default_factory=FusionParameters)
    status: StatusParameters = field(default_factory=StatusParameters)

    def __post_init__(self) -> None:
        per_image = self.association.clutter_reading == Density(per_image=True)
        if per_image and self.measurement.third_row_variance:
            raise BadParameter(
                "TrackerParameters.clutter_reading 'area' is a density over x and y; "
                "set third_row_variance=0 with it."
            )
