"""A concrete scenario of a family, the trial of a system on it, and the trial's result."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

from pjpdaf.targets import TARGETS
from reports.score.events import Event
from reports.score.records import FailureKind
from reports.score.robustness import Robustness
from scenarios.play.job import Job, System, digest_of
from scenarios.spec.parameters.file import contents
from scenarios.stress.families import find_family
from sim.motion.stage import Value

Fidelity = Literal["fast", "full"]


@dataclass(frozen=True)
class Case:
    """A concrete scenario: values of all parameters that the search varies, and a noise seed.

    values: in each parameter's unit; `fps` and `frames` may be among them. What is not among them,
    as the person's build and looks, is drawn from the seed, with sensor, detector and motion noise:
    another seed is the same motion of another person in another picture.
    """

    family: str
    values: Mapping[str, Value]
    seed: int

    def __post_init__(self) -> None:
        # 20 and 20.0 are the same value: they must give the same digest.
        values = {n: float(v) if isinstance(v, int) else v for n, v in self.values.items()}
        object.__setattr__(self, "values", values)

    @property
    def frames(self) -> int:
        """Frames of the episode; the duration stays where `fps` changes."""
        if "frames" in self.values:
            return int(float(self.values["frames"]))
        scenario = find_family(self.family).scenario
        fps = float(self.values.get("fps", scenario.fps))
        return max(1, round(scenario.frames / scenario.fps * fps))

    def job(self, system: System, *, label: str = "", film: bool = False) -> Job:
        """The episode. Raises BenchError for values that do not fit the family."""
        changes = {**self.values, "frames": float(self.frames)}
        scenario = find_family(self.family).scenario
        return Job(
            scenario, self.seed, changes, system, label=label or scenario.name, keep_film=film
        )

    @property
    def digest(self) -> str:
        """SHA-256 of the concrete scenario; the same digest means the same pictures."""
        return digest_of(self.job(System()))

    def with_seed(self, seed: int) -> Case:
        """The same motion with other noise."""
        return replace(self, seed=seed)

    def with_values(self, values: Mapping[str, Value]) -> Case:
        """The case with some values changed."""
        return replace(self, values={**self.values, **values})

    def to_json(self) -> dict[str, Any]:
        """Plain values; files by their content."""
        return {"family": self.family, "values": contents(self.values), "seed": self.seed}

    @staticmethod
    def from_json(record: Mapping[str, Any]) -> Case:
        """The case of `to_json` (without files)."""
        return Case(str(record["family"]), dict(record["values"]), int(record["seed"]))


@dataclass(frozen=True)
class Trial:
    """A case to be played by a system; fast: without pictures, full: rendered."""

    case: Case
    system: System
    fidelity: Fidelity

    @cached_property
    def key(self) -> str:
        """SHA-256 of all that decides the result, but for the version of the code."""
        system = self.system
        record = {
            "case": self.case.digest,
            "detector": [system.detector, dict(system.detector_settings)],
            "tracker": [system.tracker, dict(system.tracker_settings)],
            "fidelity": self.fidelity,
        }
        return hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class TrialFailure:
    """A trial that gave no result. kind: for programs; reason: a line for people."""

    kind: FailureKind
    reason: str


@dataclass(frozen=True)
class TrialResult:
    """The result of a trial, without its episode.

    robustness: None where there is a failure. occluded_frames: of each target, the longest run of
    frames in which no view shows it as itself: hidden, or merged with another. blame: the stage at
    fault for each (kind, target, first frame) of an event, of a full trial that failed. cpu_s: of
    the worker; not kept, 0 where the result comes from a journal.
    """

    key: str
    robustness: Robustness | None
    events: tuple[Event, ...] = ()
    frames: int = 0
    fps: float = 0.0
    failure: TrialFailure | None = None
    occluded_frames: tuple[int, ...] = (0,) * len(TARGETS)
    blame: Mapping[tuple[str, int, int], str] = field(default_factory=dict)
    cpu_s: float = 0.0

    @property
    def failed(self) -> tuple[str, ...]:
        """The measures below 0; none where the trial gave no result."""
        return () if self.robustness is None else self.robustness.failed

    @property
    def severity(self) -> float:
        """Share of the frames that lie in a swap, a capture or a loss."""
        bad: set[int] = set()
        for event in self.events:
            if event.kind != "recovered":
                bad.update(range(event.first, event.last + 1))
        return len(bad) / self.frames if self.frames else 0.0

    def to_json(self) -> bytes:
        """Canonical JSON, without cpu_s."""
        record = asdict(self)
        del record["cpu_s"]
        record["blame"] = [[*key, stage] for key, stage in sorted(self.blame.items())]
        return json.dumps(record, sort_keys=True, separators=(",", ":")).encode()

    @staticmethod
    def from_json(data: bytes) -> TrialResult:
        """The result of `to_json`. Raises ValueError, KeyError or TypeError for other bytes."""
        record = json.loads(data)
        robustness = record["robustness"]
        if robustness is not None:
            listed = {name: tuple(robustness[name]) for name in ("lost", "coalescence_m", "ends")}
            robustness = Robustness(**{**robustness, **listed})
        failure = record["failure"]
        return TrialResult(
            key=record["key"],
            robustness=robustness,
            events=tuple(Event(**event) for event in record["events"]),
            frames=record["frames"],
            fps=record["fps"],
            failure=None if failure is None else TrialFailure(**failure),
            occluded_frames=tuple(record["occluded_frames"]),
            blame={(kind, target, first): stage for kind, target, first, stage in record["blame"]},
        )
