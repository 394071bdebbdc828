"""Overrides of a preset, and the lines of their errors."""

from __future__ import annotations

import pytest
from strategies import rig

from pjpdaf.checks import BadParameter
from pjpdaf.presets.override import override
from pjpdaf.presets.registry import find_preset
from pjpdaf.tracker.fusion.stacked import Stacked

CAMERAS = rig().cameras


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
        ({"p_detct": "0.8"}, "No parameter 'p_detct'. Did you mean 'p_detect'?"),
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
