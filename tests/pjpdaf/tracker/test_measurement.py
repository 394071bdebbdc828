"""Measurement models against finite differences and the printed matrix."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import START_W, rig

from pjpdaf.camera import project, projection_jacobian
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.measurement import MEASUREMENT_MODELS as MODELS
from pjpdaf.tracker.measurement import Projection, linearise

CAMERAS = rig().cameras
LITERAL = PRESETS["thesis-literal"].tracker
PRINTED = LITERAL.process


points = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.5, 0.5), st.floats(0.5, 1.4)).map(np.array)


@given(points)
def test_jacobian_equals_finite_differences(point: np.ndarray) -> None:
    projection = Projection.of(CAMERAS, MODELS["jacobian"])
    z, H, s = linearise(projection, point[None], third_row=False)
    step = 1e-5
    for n, camera in enumerate(CAMERAS):
        slopes = [
            (project(camera, point + d) - project(camera, point - d)) / (2 * step)
            for d in step * np.eye(3)
        ]
        # Central differences: error ~ step^2 * third derivative (~ 1e3 px/m^3) plus rounding.
        np.testing.assert_allclose(H[n, 0, :, :3], np.transpose(slopes), atol=1e-4)
        np.testing.assert_allclose(projection_jacobian(camera, point), H[n, 0, :, :3])
        np.testing.assert_allclose(z[n, 0], project(camera, point))
        np.testing.assert_allclose(s[n, 0], camera.M[2] @ [*point, 1.0])


def test_the_printed_matrix_is_not_the_jacobian() -> None:
    """Eq. 3.20 lacks -z M^3: in a parallel rig it then sees depth with the wrong sign or not."""
    point = np.array([[0.1, -0.2, 0.8]])
    true = linearise(Projection.of(CAMERAS, MODELS["jacobian"]), point, False)[1]
    printed = linearise(Projection.of(CAMERAS, MODELS["thesis"]), point, False)[1]
    centred = linearise(Projection.of(CAMERAS, MODELS["centred"]), point, False)[1]
    depth = 0  # world x runs along the optical axes
    assert np.all(np.abs(printed[..., 0, depth] - true[..., 0, depth]) > 100)
    # Zero up to rounding: with the centred origin a parallel rig does not see depth at all.
    np.testing.assert_allclose(centred[..., depth], 0.0, atol=1e-9)


def test_all_readings_predict_the_same_pixel() -> None:
    pixels = [
        linearise(Projection.of(CAMERAS, MODELS[name]), START_W, True)[0]
        for name in ("thesis", "centred", "jacobian")
    ]
    expected = np.array([project(camera, START_W) for camera in CAMERAS])
    for z in pixels:
        np.testing.assert_allclose(z, expected)


def test_behind_the_camera_there_is_no_pixel() -> None:
    behind = np.array([[5.0, 0.0, 1.0]])
    z, _, s = linearise(Projection.of(CAMERAS, MODELS["jacobian"]), behind, False)
    assert np.all(np.isnan(z))
    assert np.all(s < 0)


def test_no_camera_is_an_error() -> None:
    with pytest.raises(ValueError, match="at least one camera"):
        Projection.of((), MODELS["jacobian"])
