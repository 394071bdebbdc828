"""All and objects: targets in one blob, or a target in two."""

from __future__ import annotations

from collections.abc import Mapping

from sim.stage import Gesture

FAMILIES: Mapping[str, Gesture] = {}
