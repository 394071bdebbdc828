"""Surveys scenarios before anything is rendered: could a person do them, and how fast are they?"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from scenarios.spec.draw import MOST_JUDGED, perform
from scenarios.spec.scenario import Scenario
from sim.contact.contact import ALLOWED_PENETRATION_M
from sim.motion.measure import ALLOWED_SHORT_M, Measures, Speeds, measure
from sim.motion.motion import Performer
from sim.motion.stage import Value
from sim.person.kinematics import MAX_ELBOW_FLEXION_RAD, MAX_STRETCH, MAX_WRIST_BEND_RAD
from sim.scene.extras import WithExtras
from sim.script import Performance, Script

# Hands of people who talk, seated, from recorded motion (the catalogue's preface).
RECORDED = Speeds(
    median_mps=0.2, high_mps=1.5, top_mps=3.9, step_m=(0.058, 0.292, 0.563), missed_m=(0.097, 0.421)
)


@dataclass(frozen=True)
class SeedSurvey:
    """One performance: how often it was drawn again, what it measures, what it costs.

    build_s: to draw, plan and judge it; pose_ms: a pose, the mean over its frames.
    """

    seed: int
    redrawn: int
    build_s: float
    pose_ms: float
    measures: Measures


@dataclass(frozen=True)
class Survey:
    """A scenario over a number of seeds."""

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
        """Its overlap [m]; <= 0: nothing touches."""
        return max(seed.measures.deepest_m for seed in self.seeds)

    @property
    def short_m(self) -> float:
        """How far a palm stays from its target at most [m]."""
        return max(seed.measures.short_m for seed in self.seeds)

    @property
    def hands(self) -> Speeds:
        """Of both hands: the seeds' median of each figure, but the greatest of all top speeds."""
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
        """What a person could not do: nothing, as long as drawing again works."""
        limits = (
            ("penetration", self.deepest_m, ALLOWED_PENETRATION_M),
            ("reach", self.short_m, ALLOWED_SHORT_M),
            ("stretch", max(s.measures.stretch for s in self.seeds), MAX_STRETCH + 1e-6),
        )
        return tuple(what for what, value, most in limits if value > most)


def survey(
    scenario: Scenario, seeds: Iterable[int], overrides: Mapping[str, Value] | None = None
) -> Survey:
    """Draw, measure and time the performances of these seeds. Raises BenchError, Unposable."""
    found = []
    for seed in seeds:
        begun = perf_counter()
        performance = perform(scenario, seed, overrides)
        built = perf_counter()
        times = frame_times(performance)
        for t_s in times:
            performance.script.pose(t_s)
        posed = perf_counter()
        found.append(
            SeedSurvey(
                seed=seed,
                redrawn=performance.redrawn,
                build_s=built - begun,
                pose_ms=1000.0 * (posed - built) / len(times),
                measures=measure(performer_of(performance.script), times),
            )
        )
    if not found:
        raise ValueError("survey needs at least one seed")
    return Survey(scenario.name, tuple(found))


def frame_times(performance: Performance) -> list[float]:
    """The frames' times [s], at most as many as `scenarios.spec.draw` judges."""
    last_s = (performance.frames - 1) / performance.fps
    times: list[float] = np.linspace(0.0, last_s, min(performance.frames, MOST_JUDGED)).tolist()
    return times


def performer_of(script: Script) -> Performer:
    """The performer of a script, without what moves beside it."""
    while isinstance(script, WithExtras):
        script = script.script
    if not isinstance(script, Performer):
        raise TypeError(f"cannot measure a script of type {type(script).__name__}")
    return script


def survey_table(surveys: Sequence[Survey]) -> Table:
    """A row per scenario, and the recorded motion below them to compare with."""
    table = Table(
        title=Text("Motion as it is posed, before rendering"),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
        caption=Text(
            "inside: deepest overlap of two parts, 5 mm allowed; short: of a palm from its target, "
            "10 mm allowed; speed: of the hands, median/95 %/top; step: displacement in 1/3 s, "
            "50/90/99 %; missed: by a constant-velocity prediction, 50/90 %"
        ),
        caption_justify="left",
    )
    table.add_column("scenario", no_wrap=True)
    headings = (
        "inside\nmm",
        "short\nmm",
        f"wrist\n<= {math.degrees(MAX_WRIST_BEND_RAD):.0f} deg",
        f"elbow\n<= {math.degrees(MAX_ELBOW_FLEXION_RAD):.0f} deg",
        "hands\napart mm",
        "speed\nm/s",
        "step\nmm",
        "missed\nmm",
        "redrawn\n%",
        "pose\nms",
        "build\ns",
    )
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for row in surveys:
        table.add_row(row.name, *_cells(row), style="bold red" if row.faults else None)
    table.add_section()
    table.add_row("recorded talk", "", "", "", "", "", *_speed_cells(RECORDED), "", "", "")
    return table


def _cells(row: Survey) -> tuple[str, ...]:
    measures = [seed.measures for seed in row.seeds]
    return (
        f"{1000 * max(row.deepest_m, 0.0):.1f}",
        f"{1000 * row.short_m:.1f}",
        f"{math.degrees(max(m.wrist_bend_rad for m in measures)):.0f}",
        f"{math.degrees(max(m.elbow_flexion_rad for m in measures)):.0f}",
        f"{1000 * min(m.hands_gap_m for m in measures):.0f}",
        *_speed_cells(row.hands),
        f"{100 * row.redrawn_share:.0f}",
        f"{median(seed.pose_ms for seed in row.seeds):.2f}",
        f"{median(seed.build_s for seed in row.seeds):.2f}",
    )


def _speed_cells(speeds: Speeds) -> tuple[str, str, str]:
    return (
        f"{speeds.median_mps:.2f}/{speeds.high_mps:.2f}/{speeds.top_mps:.1f}",
        "/".join(f"{1000 * s:.0f}" for s in speeds.step_m),
        "/".join(f"{1000 * m:.0f}" for m in speeds.missed_m),
    )
