"""Rig, sensor, clock and calibration: their parameters, and the records that values give."""

from __future__ import annotations

from collections.abc import Mapping

from scenarios.parameters import Choice, Numeric, normal
from sim.specs import CalibrationError, ClockSpec, RigSpec, SensorSpec
from sim.stage import Values, number

PARAMETERS: Mapping[str, Numeric | Choice] = {
    "focal": normal("px", 420.0, 700.0, 540.0, 10.0, "focal length of both cameras"),
    "baseline": normal("m", 0.06, 0.30, 0.09, 0.003, "distance between the cameras"),
    "rig_height": normal("m", 1.20, 1.60, 1.36, 0.02, "height of the cameras"),
    "rig_tilt": normal("rad", 0.0, 0.44, 0.295, 0.01, "downward tilt of the cameras"),
    "rig_distance": normal("m", 1.10, 1.70, 1.32, 0.03, "cameras ahead of the shoulders"),
    "vergence": normal("rad", 0.0, 0.09, 0.0, 0.005, "angle between the optical axes"),
    "noise_sd": normal("grey", 0.0, 12.0, 3.0, 0.5, "sensor noise, standard deviation"),
}


def rig_of(values: Values) -> RigSpec:
    """The two cameras that film."""
    return RigSpec(
        focal_px=number(values, "focal"),
        baseline_m=number(values, "baseline"),
        height_m=number(values, "rig_height"),
        distance_m=number(values, "rig_distance"),
        tilt_rad=number(values, "rig_tilt"),
        vergence_rad=number(values, "vergence"),
    )


def sensor_of(values: Values) -> SensorSpec:
    """What the cameras do to their pictures."""
    return SensorSpec(noise_sd=number(values, "noise_sd"))


def clock_of(values: Values) -> ClockSpec:
    """When pictures are taken, and which arrive."""
    return ClockSpec()


def calibration_error_of(values: Values) -> CalibrationError:
    """How the calibration that the tracker is given is wrong."""
    return CalibrationError()
