"""The presets by name."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pjpdaf.errors import BenchError, did_you_mean
from pjpdaf.presets.default import DEFAULT
from pjpdaf.presets.record import Preset
from pjpdaf.presets.thesis import THESIS
from pjpdaf.presets.thesis_literal import THESIS_LITERAL


class UnknownPreset(BenchError):
    """No preset of that name."""

    def __init__(self, name: str, known: Collection[str]) -> None:
        super().__init__(f"No preset {name!r}.{did_you_mean(name, known)}")


PRESETS: Mapping[str, Preset] = {
    preset.name: preset for preset in (THESIS_LITERAL, THESIS, DEFAULT)
}


def find_preset(name: str) -> Preset:
    """Return the preset of that name. Raises UnknownPreset."""
    if name not in PRESETS:
        raise UnknownPreset(name, PRESETS)
    return PRESETS[name]
