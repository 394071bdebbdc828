"""The records of an episode to play: the system under test and the job."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pjpdaf.detector.external import DetectionTable
from pjpdaf.presets.names import DEFAULT_PRESET
from scenarios.spec.draw import setting_of
from scenarios.spec.parameters.file import File, contents
from scenarios.spec.scenario import Scenario, digest
from sim.motion.stage import Value


@dataclass(frozen=True)
class System:
    """The system under test: names of detector and tracker, and changed parameters of each.

    lag: frames by which estimates come later than their frame (`pjpdaf.follow`).
    """

    detector: str = DEFAULT_PRESET
    tracker: str = DEFAULT_PRESET
    detector_settings: Mapping[str, str] = field(default_factory=dict)
    tracker_settings: Mapping[str, str] = field(default_factory=dict)
    lag: int = 0


@dataclass(frozen=True)
class Job:
    """An episode to play: a pure function of scenario, seed, overrides and system.

    keep_pictures: keep overlay pictures of some frames; keep_film: keep small plain pictures of
    all frames. label: its name in the results, "" for the scenario's; kept: folder of a data set's
    sequence that is read instead of rendering; detections: a table a view in place of a detector;
    size_px: width and height of its pictures, None for the scenario's; use_cache: its pictures may
    come from the cache, and go there. Files among the overrides are read when the job is made, and
    raise BenchError where that fails.
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
    detections: tuple[DetectionTable, ...] | None = None
    use_cache: bool = True

    def __post_init__(self) -> None:
        checked = dict(self.overrides)
        for name, value in self.overrides.items():
            parameter = self.scenario.parameters.get(name)
            if isinstance(parameter, File):
                checked[name] = parameter.check(name, value)
        object.__setattr__(self, "overrides", checked)

    @property
    def name(self) -> str:
        """Its name in the results."""
        return self.label or self.scenario.name

    @property
    def frames(self) -> int:
        """How many frames it has."""
        return int(setting_of(self.scenario, self.overrides, "frames"))


def digest_of(job: Job) -> str:
    """SHA-256 of an episode: scenario, seed, overrides, content of its files, size of its pictures.

    The same digest means the same pictures. The system under test is not part of it, so that runs
    of two trackers can be paired.
    """
    changes = json.dumps(contents(job.overrides), sort_keys=True)
    words = [digest(job.scenario), str(job.seed), changes]
    words += ["{}x{}".format(*job.size_px)] if job.size_px else []
    return hashlib.sha256(" ".join(words).encode()).hexdigest()
