"""Identity traps: what nobody can tell from positions alone."""

from __future__ import annotations

from collections.abc import Mapping

from sim.stage import Gesture

FAMILIES: Mapping[str, Gesture] = {}
