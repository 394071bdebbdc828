"""`--set KEY=VALUE` arguments, by what they change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pjpdaf.errors import BenchError


@dataclass(frozen=True)
class Settings:
    """Changed parameters as texts by name: of the scenario, the detector and the tracker."""

    scenario: dict[str, str]
    detector: dict[str, str]
    tracker: dict[str, str]


def read_settings(pairs: Sequence[str]) -> Settings:
    """Read `KEY=VALUE`, `detector.KEY=VALUE` and `tracker.KEY=VALUE`.

    Raises BenchError for a pair without '=' and for a key that is given twice.
    """
    settings = Settings({}, {}, {})
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise BenchError(f"--set {pair}: must be KEY=VALUE, e.g. noise_sd=5 or tracker.gate=4")
        prefix, dot, name = key.partition(".")
        systems = {"detector": settings.detector, "tracker": settings.tracker}
        changed = systems.get(prefix if dot else "")
        changed, name = (settings.scenario, key) if changed is None else (changed, name)
        if name in changed:
            raise BenchError(f"--set {key}: given twice")
        changed[name] = value
    return settings


def read_scenario_settings(pairs: Sequence[str]) -> dict[str, str]:
    """Read `KEY=VALUE` of a scenario alone. Raises BenchError for a detector's or a tracker's."""
    settings = read_settings(pairs)
    for role, changed in (("detector", settings.detector), ("tracker", settings.tracker)):
        for key in changed:
            raise BenchError(f"--set {role}.{key}: a scenario has no {role}")
    return settings.scenario
