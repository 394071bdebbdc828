"""View and field of view: a hand that one or both cameras lose."""

from __future__ import annotations

from collections.abc import Mapping

from sim.stage import Gesture

FAMILIES: Mapping[str, Gesture] = {}
