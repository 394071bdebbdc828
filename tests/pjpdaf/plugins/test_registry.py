"""Detectors and trackers by name, and the lines of their errors."""

from __future__ import annotations

import sys
import types

import pytest
from strategies import rig

from pjpdaf.errors import BenchError
from pjpdaf.plugins.registry import (
    DETECTORS,
    TRACKERS,
    PlugInError,
    make_detector,
    make_tracker,
    plug_in_names,
)
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.filter import PJPDAF

CAMERAS = rig().cameras


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
        ("thesis", {"gat": 9}, "No parameter 'gat'. Did you mean 'gate'?"),
        (
            "default",
            {"tracker.p_detect": 0.8},
            "No parameter 'tracker.p_detect'. It is of the presets thesis and thesis-literal.",
        ),
        ("default", {"gatee": 9}, "Did you mean 'gate'? It is of the presets thesis and"),
        ("thesis", {"mean_within": 2}, "No parameter 'mean_within'. It is of the preset default."),
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
