"""Families in which a fast episode predicts what the rendered one shows, as it was measured."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FILE = Path(__file__).with_name("fast_trust.json")
LEAST_EPISODES = 6  # of a family, before anything is said of it
LEAST_SHARE = 0.8  # of its episodes, in which both fail or neither does


@dataclass(frozen=True)
class FastTrust:
    """Agreement of fast with full in a family: episodes; both, only_full, only_fast: failed."""

    episodes: int
    both: int
    only_full: int
    only_fast: int

    @property
    def share(self) -> float:
        """Share of the episodes in which fast and full agree."""
        return 1.0 - (self.only_full + self.only_fast) / self.episodes

    @property
    def trusted(self) -> bool:
        """Whether fast predicts full: else the family is to be searched in full."""
        return self.episodes >= LEAST_EPISODES and self.share >= LEAST_SHARE


@cache
def fast_trust(system: str) -> dict[str, FastTrust]:
    """Scenario -> agreement, of a preset; empty for a system that was not measured."""
    record = json.loads(FILE.read_text(encoding="utf-8"))["systems"].get(system, {})
    return {name: FastTrust(**counts) for name, counts in record.items()}


def trusted(system: str, scenario: str) -> bool | None:
    """Whether fast predicts full for a preset in a scenario; None where it was not measured."""
    found = fast_trust(system).get(scenario)
    return None if found is None else found.trusted
