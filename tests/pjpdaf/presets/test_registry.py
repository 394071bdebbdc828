"""The presets: Table 4.1, departures, names."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import pytest
from strategies import rig

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.errors import BenchError
from pjpdaf.presets.flat import flat_values
from pjpdaf.presets.record import Preset
from pjpdaf.presets.registry import PRESETS, UnknownPreset, find_preset
from pjpdaf.tracker.parameters import TrackerParameters

CAMERAS = rig().cameras


def test_thesis_literal_is_table_4_1() -> None:
    preset = find_preset("thesis-literal")
    t, d = (SimpleNamespace(**flat_values(part)) for part in (preset.tracker, preset.detector))
    assert (d.min_area_px, d.kmeans_penalty, d.extra_hypotheses) == (500.0, 5.0, 2)
    assert (d.reference_focal_px, d.subsample, d.undistort) == (0.0, 1, "picture")
    assert (t.p_detect, t.gate, t.clutter) == (0.9, 15.0, 0.1)
    assert (t.measurement_px2, t.third_row_variance) == (15.0, 0.5)
    # mm^2 and (mm/frame)^2 at three frames a second.
    assert t.start_position_m2 == pytest.approx(70e-6)
    assert t.start_velocity_m2ps2 == pytest.approx(30e-6 * 9)
    assert t.process_position_m2 == pytest.approx(50e-6)
    assert t.process_velocity_m2ps2 == pytest.approx(5e-6 * 9)
    readings = (t.measurement, t.clutter_reading, t.update, t.beta_0, t.occlusion, t.process)
    assert readings == ("thesis", "density", "stacked", "sum", "shared_measurement", "per_frame")


def test_every_departure_says_all_of_it() -> None:
    literal, thesis = PRESETS["thesis-literal"], PRESETS["thesis"]
    for preset in PRESETS.values():
        assert len({departure.name for departure in preset.departures}) == len(preset.departures)
        for departure in preset.departures:
            assert all(dataclasses.astuple(departure))
    # Each field in which the two presets differ is named by a departure of 'thesis'.
    written = " ".join(departure.ours + departure.thesis for departure in thesis.departures)
    for part in ("tracker", "detector"):
        ours, theirs = flat_values(getattr(thesis, part)), flat_values(getattr(literal, part))
        for name in ours:
            if ours[name] != theirs[name]:
                assert f"`{name}`" in written, name


def test_unknown_preset() -> None:
    with pytest.raises(UnknownPreset) as fault:
        find_preset("tesis")
    assert str(fault.value) == (
        "No preset 'tesis'. Did you mean 'thesis'? Known: thesis, thesis-literal."
        if set(PRESETS) == {"thesis", "thesis-literal"}
        else str(fault.value)
    )
    assert isinstance(fault.value, BenchError)


def test_default_parameters_are_valid_and_frozen() -> None:
    preset = Preset("mine", DetectorParameters(), TrackerParameters(), ())
    with pytest.raises(dataclasses.FrozenInstanceError):
        preset.tracker.association.gate = 1.0  # type: ignore[misc]
    assert math.isclose(preset.detector.centre_sd_px**2, preset.tracker.measurement.measurement_px2)
