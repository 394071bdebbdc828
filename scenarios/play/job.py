"""The records of an episode to play: the system under test and the job."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from scenarios.spec.parameters.file import File, contents
from scenarios.spec.scenario import Scenario, digest
from sim.motion.stage import Value


@dataclass(frozen=True)
class System:
    """What is under test: detector and tracker by name, and changed parameters of each."""

    detector: str = "thesis"
    tracker: str = "thesis"
    detector_settings: Mapping[str, str] = field(default_factory=dict)
    tracker_settings: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Job:
    """One episode to play: a pure function of (scenario, seed, overrides, system).

    keep_pictures: of some frames; keep_film: small and plain, of all frames.
    label: its name in the results, where that is not the scenario's. kept: the folder of a data
    set's sequence that is read instead of rendering the episode; size_px: width and height of its
    pictures, where they are not the scenario's. Files among the overrides are
    found when the job is made: raises BenchError where that fails.
    """

    scenario: Scenario
    seed: int
    overrides: Mapping[str, Value]
    system: System
    keep_pictures: bool = False
    label: str = ""
    keep_film: bool = False
    kept: Path | None = None
    size_px: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        found = dict(self.overrides)
        for name, value in self.overrides.items():
            parameter = self.scenario.parameters.get(name)
            if isinstance(parameter, File):
                found[name] = parameter.check(name, value)
        object.__setattr__(self, "overrides", found)

    @property
    def name(self) -> str:
        """What the results call it."""
        return self.label or self.scenario.name


def digest_of(job: Job) -> str:
    """SHA-256 of an episode: scenario, seed, changed values, what is in its files, its size.

    Same digest, same pictures.

    The system under test is not part of it, so that runs of two trackers can be paired.
    """
    changes = json.dumps(contents(job.overrides), sort_keys=True)
    words = [digest(job.scenario), str(job.seed), changes]
    words += ["{}x{}".format(*job.size_px)] if job.size_px else []
    return hashlib.sha256(" ".join(words).encode()).hexdigest()
