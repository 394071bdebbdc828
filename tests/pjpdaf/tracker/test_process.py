"""Process noise and the first covariance."""

from __future__ import annotations

import numpy as np
from strategies import rig

from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.process import ProcessParameters, Scaled, process_noise, transition
from pjpdaf.tracker.start import start_covariance
from pjpdaf.tracker.thesis_units import FRAME_S

CAMERAS = rig().cameras
LITERAL = PRESETS["thesis-literal"].tracker
PRINTED = LITERAL.process


def test_process_noise_follows_the_time_step_unless_literal() -> None:
    scaled = ProcessParameters(process=Scaled())
    np.testing.assert_allclose(
        process_noise(scaled, FRAME_S / 2) * 2, process_noise(scaled, FRAME_S)
    )
    np.testing.assert_array_equal(process_noise(PRINTED, 0.01), process_noise(PRINTED, 1.0))
    # Table 4.1: 50 mm^2 and 5 (mm/frame)^2 at three frames a second.
    np.testing.assert_allclose(np.diag(process_noise(PRINTED, FRAME_S)), [50e-6] * 3 + [45e-6] * 3)
    np.testing.assert_allclose(np.diag(start_covariance(LITERAL.start)), [70e-6] * 3 + [270e-6] * 3)


def test_constant_velocity() -> None:
    state = np.array([1.0, 2.0, 3.0, 0.1, -0.2, 0.3])
    np.testing.assert_allclose(transition(0.5) @ state, [1.05, 1.9, 3.15, 0.1, -0.2, 0.3])
    # Two half steps are one whole step.
    np.testing.assert_allclose(transition(0.5) @ transition(0.5), transition(1.0))
