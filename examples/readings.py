"""Plays scenarios once, then replays their detections through other readings of the tracker.

Prints the table of docs/algorithm.md, "Effects on pictures": python examples/readings.py 100 110
"""

from __future__ import annotations

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from pjpdaf.presets.override import with_values
from pjpdaf.presets.registry import find_preset
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.thesis_units import FRAME_S
from reports.run.rows import rows_of
from reports.score.records import Episode
from scenarios.play.job import Job, System
from scenarios.play.oracle import Oracle, track_again
from scenarios.play.play import play
from scenarios.spec.names import load_scenario

SCENARIOS = ("calm_table", "drink", "cross", "bounce", "speed_ladder")
Q_POSITION, Q_VELOCITY = 50e-6, 5e-6 / FRAME_S**2
READINGS: tuple[tuple[str, dict[str, object]], ...] = (
    ("thesis", {}),
    ("measurement=thesis", {"measurement": "thesis"}),
    ("measurement=centred", {"measurement": "centred"}),
    ("clutter_reading=density", {"clutter_reading": "density"}),
    ("clutter_reading=area, clutter=0.2", {"clutter_reading": "area", "clutter": 0.2}),
    ("update=sequential", {"update": "sequential"}),
    ("update=stacked", {"update": "stacked"}),
    ("update=stacked, beta_0=sum", {"update": "stacked", "beta_0": "sum"}),
    ("update=stacked_detected", {"update": "stacked_detected"}),
    ("update=stacked_weighted", {"update": "stacked_weighted"}),
    ("update=most_probable", {"update": "most_probable"}),
    ("occlusion=shared_measurement", {"occlusion": "shared_measurement"}),
    ("occlusion=none", {"occlusion": "none"}),
    *(
        (
            f"Q: position x {a}, velocity x {b}",
            {"process_position_m2": a * Q_POSITION, "process_velocity_m2ps2": b * Q_VELOCITY},
        )
        for a, b in ((1, 1), (16, 16), (16, 64), (64, 1), (32, 0), (128, 0))
    ),
)


def film(task: tuple[str, int]) -> Episode:
    name, seed = task
    frames = {"frames": 60} if name == "calm_table" else {}
    return play(Job(load_scenario(name), seed, frames, System()))


def replayed(episode: Episode, changes: dict[str, object]) -> Episode:
    parameters = with_values(find_preset("thesis").tracker, changes)
    return track_again(episode, episode.cameras, PJPDAF(episode.cameras, parameters), Oracle())


def cell(episodes: list[Episode], changes: dict[str, object]) -> tuple[float, str]:
    rows = [rows_of(replayed(episode, changes)) for episode in episodes]
    errors = np.array([error for row in rows for error in row.frames["error_mm"]], dtype=float)
    within = float(np.mean(np.nan_to_num(errors, nan=np.inf) < 100.0))
    swapped = sum(any(target["ever_swapped"] for target in row.episodes) for row in rows)
    lost = sum(any(target["ever_lost"] for target in row.episodes) for row in rows)
    return within, f"{100 * within:.1f} %, {swapped}, {lost}"


def main(first: int, end: int) -> None:
    tasks = [(name, seed) for name in SCENARIOS for seed in range(first, end)]
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as pool:
        films = list(pool.map(film, tasks))
    print("| changed | " + " | ".join(SCENARIOS) + " | mean |")
    print("|---" * (len(SCENARIOS) + 2) + "|")
    for label, changes in READINGS:
        cells = [cell([f for f in films if f.scenario == name], changes) for name in SCENARIOS]
        mean = 100 * np.mean([within for within, _ in cells])
        texts = " | ".join(text for _, text in cells)
        print(f"| `{label}` | {texts} | {mean:.1f} % |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
