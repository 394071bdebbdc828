"""Flat names of the parameters, and the words of the variants."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import pytest
from strategies import rig

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.presets.flat import VARIANTS, flat_names, flat_values, leaves
from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.clutter import Density
from pjpdaf.tracker.occlusion import FewerMeasurements
from pjpdaf.tracker.parameters import TrackerParameters

CAMERAS = rig().cameras


ROOT = Path(__file__).parents[3]


def test_flat_names_do_not_clash() -> None:
    """Or a bare KEY=VALUE would be ambiguous."""
    assert not set(flat_names(DetectorParameters)) & set(flat_names(TrackerParameters))


def test_names_and_values_are_those_of_run_json() -> None:
    """A saved run from before the records were nested has the same names and values."""
    saved = json.loads((ROOT / "reports/accepted/smoke-thesis/run.json").read_text())["parameters"]
    for part in ("detector", "tracker"):
        values = json.loads(json.dumps(flat_values(getattr(PRESETS["thesis"], part))))
        assert values == saved[part]


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_every_word_becomes_its_variant_and_back(name: str) -> None:
    preset = PRESETS["thesis"]
    part = "detector" if name in flat_names(DetectorParameters) else "tracker"
    for word, variant in VARIANTS[name].items():
        changed = with_values(getattr(preset, part), {name: word})
        assert flat_values(changed)[name] == word
        (leaf,) = (leaf for leaf in leaves(type(changed)) if leaf.name == name)
        assert functools.reduce(getattr, leaf.path, changed) == variant
    assert len(set(VARIANTS[name].values())) == len(VARIANTS[name])


def test_a_variant_of_ones_own_goes_by_its_description() -> None:
    certain = TrackerParameters(occlusion=FewerMeasurements(certain=0.8))
    assert flat_values(certain)["occlusion"] == "FewerMeasurements(certain=0.8)"


def test_values_of_one_record_change_together() -> None:
    """Neither change alone would pass the check of the two."""
    literal = PRESETS["thesis-literal"].tracker
    changed = with_values(literal, {"clutter_reading": "area", "third_row_variance": 0})
    assert changed.association.clutter_reading == Density(per_image=True)
    assert changed.measurement.third_row_variance == 0.0
