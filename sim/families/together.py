"""Hand and hand: clasped, clapping, rolling, passing a thing."""

from __future__ import annotations

from collections.abc import Mapping

from sim.stage import Gesture

FAMILIES: Mapping[str, Gesture] = {}
