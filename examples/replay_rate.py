"""What footage from the cache costs against rendering: CPU time of the same episodes, in a worker.

And how many stereo frames a second detector and tracker manage on one core.

python examples/replay_rate.py calm_table drink touch_face cross     # entries of the suite core
python examples/replay_rate.py cross frames=12                        # with changed parameters
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from pjpdaf.follow import follow
from scenarios.execute.local import local_executor
from scenarios.play.footage import open_footage
from scenarios.play.job import Job
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import make_system, play_complete
from sim.processes import Answer

T = TypeVar("T")
WARMING_FRAMES = 2
PASSES = 6  # over the same pictures, of which the least counts


def cpu_s(work: Callable[[Job], T], job: Job) -> tuple[float, T]:
    start = time.process_time()
    value = work(job)
    return time.process_time() - start, value


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


def measure(job: Job) -> tuple[int, float, float, float, float]:
    """Frames of an episode, and its CPU time [s]: rendered, replayed, the footage alone, detector
    and tracker alone.
    """
    rendered_s, episode = cpu_s(play_complete, job)
    replayed_s, again = cpu_s(play_complete, job)
    assert not episode.replayed
    assert again.replayed
    watched_s, frames = cpu_s(watch, job)
    return frames, rendered_s, replayed_s, watched_s, follow_s(job)


def main() -> None:
    settings = tuple(word for word in sys.argv[1:] if "=" in word)
    only = tuple(word for word in sys.argv[1:] if "=" not in word)
    jobs = plan(PlanRequest(("core",), 1, 7000, settings=settings, only=only))
    warming = plan(PlanRequest(("cross",), seeds=1, settings=(f"frames={WARMING_FRAMES}",)))
    rows = []
    with TemporaryDirectory() as folder:
        os.environ["PJPDAF_BENCH_CACHE"] = folder
        with local_executor(1) as executor:
            for done in executor.outcomes(measure, dict(enumerate(warming + jobs)), 3600.0):
                if done is not None and isinstance(done[1], Answer) and done[0] > 0:
                    rows.append(done[1].value)
                    print(f"{jobs[done[0] - 1].name}: {rows[-1][0]} frames")
        kept_bytes = sum(path.stat().st_size for path in Path(folder).rglob("*.rec"))
    frames, rendered_s, replayed_s, watched_s, followed_s = (
        sum(column) for column in zip(*rows, strict=True)
    )
    print(f"kept: {kept_bytes / 1e3 / (frames + WARMING_FRAMES):.0f} kB a stereo frame")
    print(f"CPU per stereo frame, {frames} frames:")
    for text, slow_s, quick_s in (
        ("footage", rendered_s - replayed_s + watched_s, watched_s),
        ("whole episode", rendered_s, replayed_s),
    ):
        print(
            f"  {text}: rendered {1e3 * slow_s / frames:.1f} ms, replayed "
            f"{1e3 * quick_s / frames:.1f} ms, {slow_s / quick_s:.1f} times as fast"
        )
    print(
        f"  detector and tracker, the least of {PASSES} passes: {1e3 * followed_s / frames:.1f} "
        f"ms, {frames / followed_s:.0f} stereo frames a second"
    )


if __name__ == "__main__":
    main()
