"""What episodes from the cache cost against rendering them: CPU time of the same ones, in a worker.

As `run` plays them: scored, with blame, error budget and a small film. And how many stereo frames a
second detector and tracker manage on one core.

python examples/replay_rate.py calm_table drink touch_face cross     # entries of the suite core
python examples/replay_rate.py cross frames=12                        # with changed parameters
python examples/replay_rate.py cross --preset thesis
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple, TypeVar

from pjpdaf.follow import follow
from reports.run.rows import EpisodeRows, rows_of
from scenarios.cache.array_file import arrays_from_bytes
from scenarios.cache.folder import CacheFolder, Kind
from scenarios.cache.report import required_settings
from scenarios.execute.local import local_executor
from scenarios.play.footage import open_footage
from scenarios.play.job import Job
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import make_system, play_complete
from sim.processes import Answer

T = TypeVar("T")
WARMING_FRAMES = 12
ROUNDS = 2  # of which the least counts
PASSES = 6  # over the same pictures, of which the least counts
CHANGED_TRACKERS = {  # about as dear as it was
    "default": {"epipolar_px": "5", "miss": "8"},
    "thesis": {"gate": "12"},
}


class Spent(NamedTuple):
    """CPU time [s] of an episode: rendered; replayed with another detector, or another tracker;
    the footage alone; detector and tracker alone. frames: it has; detected: of these, those that
    the other tracker's predictions made the detector look at again; footage, detections, films,
    scenes: bytes on the disk.
    """

    frames: int
    rendered_s: float
    other_detector_s: float
    other_tracker_s: float
    watched_s: float
    followed_s: float
    detected: int
    footage: int
    detections: int
    films: int
    scenes: int


def cpu_s(work: Callable[[Job], T], job: Job) -> tuple[float, T]:
    start = time.process_time()
    value = work(job)
    return time.process_time() - start, value


def played(job: Job) -> EpisodeRows:
    return rows_of(play_complete(job))


def watch(job: Job) -> int:
    with open_footage(job) as footage:
        footage.background()
        return sum(1 for _ in footage.frames())


def follow_s(job: Job) -> float:
    """CPU time [s] of detector and tracker in all frames of an episode."""
    with open_footage(job) as footage:
        detector, tracker = make_system(job.system, footage.calibration)
        learnt = detector.learn(footage.background())
        frames = [frame for frame, _ in footage.frames()]

    def pass_over(job: Job) -> int:
        return sum(1 for _ in follow(frames, learnt, tracker))

    return min(cpu_s(pass_over, job)[0] for _ in range(PASSES))


def only_file(kind: Kind) -> Path:
    """The only entry of a kind in the cache."""
    entries = CacheFolder(required_settings()).entries()
    (path,) = (entry.path for entry in entries if entry.kind == kind)
    return path


def measure(job: Job) -> Spent:
    """The least CPU time of an episode in each way, of `ROUNDS` with an empty cache."""
    rounds = [measure_once(job) for _ in range(ROUNDS)]
    return Spent(*(min(column) for column in zip(*rounds, strict=True)))


def measure_once(job: Job) -> Spent:
    """Play an episode in every way; the first renders it, all others take it from the cache."""
    CacheFolder(required_settings()).clear()
    rendered_s, rendered = cpu_s(played, job)
    changed = replace(job.system, tracker_settings=CHANGED_TRACKERS[job.system.tracker])
    other_tracker_s, tracked = cpu_s(played, replace(job, system=changed))
    content = only_file(Kind.DETECTIONS).read_bytes()
    answers = len(arrays_from_bytes(content)[1]["frames"])
    sizes = [only_file(kind).stat().st_size for kind in Kind]
    # As if the detector were another, but for what it sees in the empty room.
    only_file(Kind.DETECTIONS).unlink()
    other_detector_s, detected = cpu_s(played, job)
    assert (rendered.replayed, tracked.replayed, detected.replayed) == (False, True, True)
    assert not detected.detections_kept
    watched_s, frames = cpu_s(watch, job)
    times_s = rendered_s, other_detector_s, other_tracker_s, watched_s, follow_s(job)
    return Spent(frames, *times_s, answers - frames, *sizes)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("words", nargs="+", metavar="NAME | KEY=VALUE")
    parser.add_argument("--preset", choices=CHANGED_TRACKERS, default="default")
    arguments = parser.parse_intermixed_args()
    settings = tuple(word for word in arguments.words if "=" in word)
    only = tuple(word for word in arguments.words if "=" not in word)
    preset = arguments.preset
    request = PlanRequest(
        ("core",), 1, 7000, only, settings, detector=preset, tracker=preset, keep_films=True
    )
    jobs = plan(request)
    warming = plan(replace(request, only=("cross",), settings=(f"frames={WARMING_FRAMES}",)))
    rows: list[Spent] = []
    with TemporaryDirectory() as folder:
        os.environ["PJPDAF_BENCH_CACHE"] = folder
        with local_executor(1) as executor:
            for done in executor.outcomes(measure, dict(enumerate(warming + jobs)), 3600.0):
                assert done is None or isinstance(done[1], Answer), done
                if done is not None and isinstance(done[1], Answer) and done[0] > 0:
                    rows.append(done[1].value)
                    print(f"{jobs[done[0] - 1].name}: {rows[-1].frames} frames", flush=True)
    spent = Spent(*(sum(column) for column in zip(*rows, strict=True)))
    sizes = spent.footage, spent.detections, spent.films, spent.scenes
    each = ", ".join(
        f"{kind} {size / 1e3 / spent.frames:.1f} kB" for kind, size in zip(Kind, sizes, strict=True)
    )
    print(f"kept of a stereo frame: {each}")
    print(f"CPU per stereo frame, {spent.frames} frames, preset {preset}:")
    footage_s = spent.rendered_s - spent.other_detector_s + spent.watched_s
    for text, slow_s, quick_s in (
        ("footage", footage_s, spent.watched_s),
        ("whole episode, another detector", spent.rendered_s, spent.other_detector_s),
        ("whole episode, another tracker", spent.rendered_s, spent.other_tracker_s),
    ):
        print(
            f"  {text}: rendered {1e3 * slow_s / spent.frames:.1f} ms, replayed "
            f"{1e3 * quick_s / spent.frames:.1f} ms, {slow_s / quick_s:.1f} times as fast"
        )
    print(f"  of the other tracker's frames {spent.detected} were detected again")
    print(
        f"  detector and tracker, the least of {PASSES} passes: "
        f"{1e3 * spent.followed_s / spent.frames:.1f} ms, "
        f"{spent.frames / spent.followed_s:.0f} stereo frames a second"
    )


if __name__ == "__main__":
    main()
