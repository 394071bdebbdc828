"""Parameters of rig, sensor, clock and calibration, and the records that their values make."""

from __future__ import annotations

import math
from collections.abc import Mapping

from pjpdaf.errors import BenchError
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.parameter import choice, fixed, normal, uniform
from sim.camera.colour import NEUTRAL_K, balance_rgb
from sim.lens import check
from sim.motion.stage import Values, number
from sim.scene.rig import stereo_rig
from sim.specs import CalibrationError, ClockSpec, RigSpec, SensorSpec

# From shot_noise on, all is nominally as if it were not there; the ranges are those of the scenario
# catalogue's nuisances. The lens: barrel to pincushion as far as any k2 goes with any k1 at 490 px
# of focal length and more; the corners of the picture move by up to 22 %.
PARAMETERS: Mapping[str, Numeric | Choice] = {
    "focal": normal("px", 420.0, 700.0, 540.0, 10.0, "focal length of both cameras"),
    "baseline": normal("m", 0.06, 0.30, 0.09, 0.003, "distance between the cameras"),
    "rig_height": normal("m", 1.20, 1.60, 1.36, 0.02, "height of the cameras"),
    "rig_tilt": normal("rad", 0.0, 0.44, 0.295, 0.01, "downward tilt of the cameras"),
    "rig_distance": normal("m", 1.10, 1.70, 1.32, 0.03, "cameras ahead of the shoulders"),
    "vergence": normal("rad", 0.0, 0.09, 0.0, 0.005, "angle between the optical axes"),
    "noise_sd": normal("grey", 0.0, 12.0, 3.0, 0.5, "sensor noise, standard deviation"),
    "shot_noise": fixed("grey", 0.0, 12.0, 0.0, "noise of the light itself, at grey level 128"),
    "jpeg_quality": fixed("1", 60.0, 100.0, 100.0, "JPEG quality; 100 is not compressed"),
    "exposure_time": fixed("ms", 0.0, 40.0, 0.0, "time that a picture is exposed, for the blur"),
    "exposure": fixed("EV", -1.5, 1.5, 0.0, "over- or underexposure, powers of two of the light"),
    "white_balance": fixed(
        "K", 2700.0, 7500.0, NEUTRAL_K, "temperature of the light that the cameras show as white"
    ),
    "flicker": fixed("%", 0.0, 5.0, 0.0, "share by which the light swings"),
    "flicker_rate": fixed("Hz", 80.0, 130.0, 100.0, "how often the light swings"),
    "flicker_phase": uniform(
        "rad", (0.0, 2 * math.pi), 0.0, 2 * math.pi, "where the swing of the light begins"
    ),
    "shutter_skew": fixed("ms", 0.0, 50.0, 0.0, "right view exposed later than the left by this"),
    "jitter": fixed("ms", 0.0, 50.0, 0.0, "frames taken before or after their time, at most"),
    "stamps": choice({"actual": 1.0, "nominal": 0.0}, "which time frames carry"),
    "dropped": fixed("%", 0.0, 10.0, 0.0, "share of a view's pictures that are lost"),
    "lens_k1": fixed("1", -0.22, 0.15, 0.0, "lens distortion, first radial coefficient"),
    "lens_k2": fixed("1", 0.0, 0.2, 0.0, "lens distortion, second radial coefficient"),
    "principal_x": fixed("px", -30.0, 30.0, 0.0, "principal point right of the picture's middle"),
    "principal_y": fixed("px", -30.0, 30.0, 0.0, "principal point below the picture's middle"),
    "calibration_baseline": fixed("%", -5.0, 5.0, 0.0, "baseline overstated by the calibration"),
    "calibration_focal": fixed("%", -3.0, 3.0, 0.0, "focal lengths overstated likewise"),
    "calibration_rot_x": fixed("deg", -1.0, 1.0, 0.0, "right camera wrongly turned about its x"),
    "calibration_rot_y": fixed("deg", -1.0, 1.0, 0.0, "right camera wrongly turned about its y"),
    "calibration_rot_z": fixed("deg", -1.0, 1.0, 0.0, "right camera wrongly turned about its z"),
}


def rig_of(values: Values) -> RigSpec:
    """The stereo rig. Raises BenchError for a lens that shows some points twice."""
    distortion = number(values, "lens_k1"), number(values, "lens_k2"), 0.0, 0.0
    rig = RigSpec(
        focal_px=number(values, "focal"),
        baseline_m=number(values, "baseline"),
        height_m=number(values, "rig_height"),
        distance_m=number(values, "rig_distance"),
        tilt_rad=number(values, "rig_tilt"),
        vergence_rad=number(values, "vergence"),
        principal_offset_px=(number(values, "principal_x"), number(values, "principal_y")),
        distortion=distortion if any(distortion) else (),
    )
    try:
        check(stereo_rig(rig).left)
    except ValueError as fault:
        raise BenchError(
            f"lens_k1, lens_k2: {fault}; take a smaller lens_k1, a greater lens_k2 or focal"
        ) from None
    return rig


def sensor_of(values: Values) -> SensorSpec:
    """The sensor: exposure, noise, colour, compression of the pictures."""
    return SensorSpec(
        exposure_time_s=number(values, "exposure_time"),
        skew_s=number(values, "shutter_skew"),
        exposure_ev=number(values, "exposure"),
        white_balance_rgb=balance_rgb(number(values, "white_balance")),
        flicker=number(values, "flicker"),
        flicker_hz=number(values, "flicker_rate"),
        flicker_rad=number(values, "flicker_phase"),
        noise_sd=number(values, "noise_sd"),
        shot_noise_sd=number(values, "shot_noise"),
        jpeg_quality=round(number(values, "jpeg_quality")),
    )


def clock_of(values: Values) -> ClockSpec:
    """The times at which pictures are taken, and the share that is lost."""
    return ClockSpec(
        jitter_s=number(values, "jitter"),
        stamps=str(values["stamps"]),
        dropped=number(values, "dropped"),
    )


def calibration_error_of(values: Values) -> CalibrationError:
    """The error of the calibration that the tracker is given."""
    x, y, z = (number(values, f"calibration_rot_{axis}") for axis in "xyz")
    return CalibrationError(
        baseline=number(values, "calibration_baseline"),
        focal=number(values, "calibration_focal"),
        rotation_rad=(x, y, z),
    )
