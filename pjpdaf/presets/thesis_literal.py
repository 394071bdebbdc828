"""Preset 'thesis-literal': every equation and constant as printed."""

from __future__ import annotations

from pjpdaf.detector.background import BackgroundParameters
from pjpdaf.detector.clusters import ClusterParameters
from pjpdaf.detector.components import ComponentParameters
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.skin import SkinRange
from pjpdaf.detector.undistortion import UndistortPicture
from pjpdaf.presets.common import COMMON
from pjpdaf.presets.record import Departure, Preset
from pjpdaf.tracker.association import AssociationParameters
from pjpdaf.tracker.clutter import Density
from pjpdaf.tracker.fusion.missed import SumOfViews
from pjpdaf.tracker.fusion.registry import FusionParameters
from pjpdaf.tracker.fusion.stacked import Stacked
from pjpdaf.tracker.measurement import LambdaM, MeasurementParameters
from pjpdaf.tracker.occlusion import SharedMeasurement
from pjpdaf.tracker.parameters import TrackerParameters
from pjpdaf.tracker.process import PerFrame, ProcessParameters

TINY_FLOORS = Departure(
    "floors of the background's deviations",
    "none (section 3.1.1)",
    "about one step of 8-bit HSV",
    "a pixel that never changed has variance 0, and then every pixel is foreground",
    "makes the printed method computable",
)

THESIS_LITERAL = Preset(
    "thesis-literal",
    DetectorParameters(
        undistort=UndistortPicture(),
        skin=SkinRange(value_min=0.0),
        background=BackgroundParameters(
            hue_sd_floor_deg=2.0, sat_sd_floor=1 / 255, val_sd_floor=1 / 255, shadow_min=1.0
        ),
        components=ComponentParameters(
            min_area_px=500.0,
            reference_focal_px=0.0,
            reference_depth_m=0.0,
            merge_fragments=False,
        ),
        clusters=ClusterParameters(subsample=1, components_compete=False),
    ),
    TrackerParameters(
        process=ProcessParameters(process=PerFrame()),
        measurement=MeasurementParameters(measurement=LambdaM(), third_row_variance=0.5),
        association=AssociationParameters(clutter_reading=Density()),
        occlusion=SharedMeasurement(),
        fusion=FusionParameters(update=Stacked(), beta_0=SumOfViews()),
    ),
    (*COMMON, TINY_FLOORS),
)
