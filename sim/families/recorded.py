"""Recorded motion: a clip played by the person."""

from __future__ import annotations

from collections.abc import Mapping

from sim.stage import Gesture

FAMILIES: Mapping[str, Gesture] = {}
