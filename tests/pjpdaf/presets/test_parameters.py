"""Presets, overrides, the registry, and the words of their errors."""

from __future__ import annotations

import dataclasses
import math
import sys
import types
from types import SimpleNamespace

import pytest
from strategies import rig

from pjpdaf.checks import BadParameter
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.errors import BenchError
from pjpdaf.plugins.registry import (
    DETECTORS,
    TRACKERS,
    PlugInError,
    make_detector,
    make_tracker,
    plug_in_names,
)
from pjpdaf.presets.flat import flat_names, flat_values
from pjpdaf.presets.override import override
from pjpdaf.presets.record import Preset
from pjpdaf.presets.registry import PRESETS, UnknownPreset, find_preset
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.fusion.stacked import Stacked
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


def test_overrides_are_read_as_their_type() -> None:
    preset = override(
        find_preset("thesis"),
        {
            "p_detect": "0.8",
            "tracker.update": "stacked",
            "hue_range_deg": "350, 20",
            "detector.merge_fragments": "Yes",
            "subsample": "4",
            "start_depth_m": (0.5, 2),
            "gate": 9,
        },
    )
    assert preset.tracker.association.p_detect == 0.8
    assert preset.tracker.fusion.update == Stacked()
    assert preset.tracker.start.start_depth_m == (0.5, 2.0)
    assert preset.tracker.association.gate == 9.0
    assert preset.detector.skin.hue_range_deg == (350.0, 20.0)
    assert preset.detector.components.merge_fragments is True
    assert preset.detector.clusters.subsample == 4
    assert find_preset("thesis").tracker.association.p_detect == 0.9
    assert override(preset, {}) == preset


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"p_detct": "0.8"}, "No parameter 'p_detct'. Did you mean 'p_detect'? Known: "),
        ({"detector.gate": "1"}, "No parameter 'detector.gate'."),
        ({"motor.gate": "1"}, "No parameter 'motor.gate'. Did you mean 'gate'?"),
        ({"p_detect": "high"}, "p_detect must be a number, got 'high'."),
        ({"p_detect": "nan"}, "p_detect must be a number, got 'nan'."),
        ({"p_detect": True}, "p_detect must be a number, got True."),
        ({"p_detect": "1.5"}, "TrackerParameters.p_detect must be between 0 and 1, got 1.5."),
        ({"subsample": "2.5"}, "subsample must be a whole number, got '2.5'."),
        ({"update": "stack"}, "update must be one of 'stacked', "),
        ({"merge_fragments": "maybe"}, "merge_fragments must be true or false, got 'maybe'."),
        ({"hue_range_deg": "3"}, "hue_range_deg must be 2 numbers with commas between, got '3'."),
        ({"saturation_range": "0.6,0.2"}, "saturation_range must be min < max within 0..1"),
        ({"clutter": "0"}, "TrackerParameters.clutter must be above 0, got 0.0."),
        ({"min_area_px": "-1"}, "DetectorParameters.min_area_px must be at least 0, got -1.0."),
        ({"clutter_reading": "area", "third_row_variance": 1}, "set third_row_variance=0"),
    ],
)
def test_a_wrong_override_is_one_clear_line(values: dict[str, object], words: str) -> None:
    with pytest.raises(BadParameter) as fault:
        override(find_preset("thesis"), values)
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)
    assert fault.value.exit_code == 2


def test_flat_names_do_not_clash() -> None:
    """Or a bare KEY=VALUE would be ambiguous."""
    assert not set(flat_names(DetectorParameters)) & set(flat_names(TrackerParameters))


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


@pytest.fixture
def plugin(monkeypatch: pytest.MonkeyPatch) -> types.ModuleType:
    module = types.ModuleType("plugin_of_a_user")
    module.tracker = lambda cameras: PJPDAF(cameras)
    module.half = lambda cameras: object()
    module.number = 3
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return module


def test_trackers_by_name(plugin: types.ModuleType) -> None:
    tracker = make_tracker("thesis", CAMERAS, {"gate": "9", "min_area_px": "10"})
    assert tracker.parameters.association.gate == 9.0
    assert isinstance(make_tracker("plugin_of_a_user:tracker", CAMERAS), PJPDAF)
    assert set(PRESETS) <= set(plug_in_names(TRACKERS))
    assert set(PRESETS) <= set(plug_in_names(DETECTORS))


def test_detectors_by_name() -> None:
    detector = make_detector("thesis", CAMERAS, {"min_area_px": "10"})
    assert detector.parameters.components.min_area_px == 10.0


@pytest.mark.parametrize(
    ("name", "overrides", "words"),
    [
        ("tesis", None, "No tracker 'tesis'. Did you mean 'thesis'? Known: "),
        ("no_such_module:make", None, "cannot be imported: No module named 'no_such_module'."),
        (":make", None, "cannot be imported"),
        ("plugin_of_a_user:traker", None, "Did you mean 'tracker'?"),
        ("plugin_of_a_user:number", None, "is no function of the cameras."),
        ("plugin_of_a_user:half", None, "lacks start, step, estimates, predict"),
        ("plugin_of_a_user:tracker", {"gate": 9}, "is a plug-in and takes no parameters, got gate"),
        ("thesis", {"gat": 9}, "No parameter 'gat'."),
    ],
)
def test_a_tracker_that_cannot_be_had(plugin, name, overrides, words) -> None:
    with pytest.raises(BenchError) as fault:
        make_tracker(name, CAMERAS, overrides)
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_plug_in_may_ignore_keys_of_the_other_part(plugin: types.ModuleType) -> None:
    make_tracker("plugin_of_a_user:tracker", CAMERAS, {"min_area_px": 9})
    with pytest.raises(PlugInError, match="lacks learn, __call__"):
        make_detector("plugin_of_a_user:half", CAMERAS, {"gate": 9})
