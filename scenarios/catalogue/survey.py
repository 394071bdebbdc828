"""Measures the motion of scenarios before rendering: could a person perform it, and how fast?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import median
from time import perf_counter

import numpy as np

from scenarios.spec.draw import MOST_JUDGED, perform
from scenarios.spec.scenario import Scenario
from sim.contact.contact import ALLOWED_PENETRATION_M
from sim.motion.measure import ALLOWED_SHORT_M, Measures, Speeds, measure
from sim.motion.motion import performer_of
from sim.motion.stage import Value
from sim.person.kinematics import MAX_STRETCH
from sim.script import Performance


@dataclass(frozen=True)
class SeedSurvey:
    """The measures of a seed's performance.

    redrawn: draws that were thrown away; build_s: time to draw, plan and judge it; pose_ms: time of
    a pose, mean over the frames.
    """

    seed: int
    redrawn: int
    build_s: float
    pose_ms: float
    measures: Measures


@dataclass(frozen=True)
class Survey:
    """The measures of a scenario over its seeds."""

    name: str
    seeds: tuple[SeedSurvey, ...]

    @property
    def redrawn_share(self) -> float:
        """Share of all draws that were thrown away."""
        thrown = sum(seed.redrawn for seed in self.seeds)
        return thrown / (thrown + len(self.seeds))

    @property
    def deepest(self) -> tuple[str, str]:
        """The pair of parts that overlaps most."""
        return max(self.seeds, key=lambda seed: seed.measures.deepest_m).measures.deepest

    @property
    def deepest_m(self) -> float:
        """The overlap of that pair [m]; <= 0: no pair touches."""
        return max(seed.measures.deepest_m for seed in self.seeds)

    @property
    def short_m(self) -> float:
        """The greatest distance of a palm from its target [m]."""
        return max(seed.measures.short_m for seed in self.seeds)

    @property
    def hands(self) -> Speeds:
        """Speeds of both hands: median over seeds of each figure, maximum of the top speeds."""
        speeds = [seed.measures.speeds["hands"] for seed in self.seeds]
        steps = np.median([s.step_m for s in speeds], axis=0).tolist()
        missed = np.median([s.missed_m for s in speeds], axis=0).tolist()
        return Speeds(
            median_mps=median(s.median_mps for s in speeds),
            high_mps=median(s.high_mps for s in speeds),
            top_mps=max(s.top_mps for s in speeds),
            step_m=(steps[0], steps[1], steps[2]),
            missed_m=(missed[0], missed[1]),
        )

    @property
    def faults(self) -> tuple[str, ...]:
        """Names of the limits that are passed: none, as long as faulty draws are thrown away."""
        limits = (
            ("penetration", self.deepest_m, ALLOWED_PENETRATION_M),
            ("reach", self.short_m, ALLOWED_SHORT_M),
            ("stretch", max(s.measures.stretch for s in self.seeds), MAX_STRETCH + 1e-6),
        )
        return tuple(name for name, value, most in limits if value > most)


def survey_scenario(
    scenario: Scenario, seeds: Iterable[int], overrides: Mapping[str, Value] | None = None
) -> Survey:
    """Draw, measure and time the performances of `seeds`. Raises BenchError, Unposable."""
    measured = []
    for seed in seeds:
        begun = perf_counter()
        performance = perform(scenario, seed, overrides)
        built = perf_counter()
        times = frame_times(performance)
        for t_s in times:
            performance.script.pose(t_s)
        posed = perf_counter()
        measured.append(
            SeedSurvey(
                seed=seed,
                redrawn=performance.redrawn,
                build_s=built - begun,
                pose_ms=1000.0 * (posed - built) / len(times),
                measures=measure(performer_of(performance.script), times),
            )
        )
    if not measured:
        raise ValueError("survey needs at least one seed")
    return Survey(scenario.name, tuple(measured))


def frame_times(performance: Performance) -> list[float]:
    """The frames' times [s], at most as many as `scenarios.spec.draw` judges."""
    last_s = (performance.frames - 1) / performance.fps
    times: list[float] = np.linspace(0.0, last_s, min(performance.frames, MOST_JUDGED)).tolist()
    return times
