"""Speed of a fast episode: its own share beside the tracker's, and episodes a second.

Never fails by the clock: the figures are printed in the benchmark's extra information. Run with
`pytest tests/bench --benchmark-enable`.
"""

from __future__ import annotations

from time import process_time

import pytest

from pjpdaf.camera import StereoRig
from pjpdaf.follow import follow
from pjpdaf.frames import StereoFrame
from scenarios.play.fast import _painting, _stand_in, play_fast
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import make_system
from scenarios.spec.draw import unjudged
from sim.silhouettes.error_model import error_model
from sim.silhouettes.film import film_of
from sim.silhouettes.painter import Painter

FAMILIES = ("cross", "merge_and_hold", "drink", "roll_forearms", "parallel", "object_splits_hand")


class Replay:
    """A detector that gives what it is told to."""

    def __init__(self, detections):
        self.detections = detections

    def __call__(self, frame, predicted=None):
        return self.detections[frame.index]


def cpu_s(call) -> float:
    begun = process_time()
    call()
    return process_time() - begun


@pytest.mark.sample(1)
@pytest.mark.parametrize("preset", ["thesis", "default"])
def test_fast_episodes(benchmark, preset):
    # Without --benchmark-enable it only has to work: one family, fewer repeats.
    families, repeats = (FAMILIES, 2) if benchmark.enabled else (FAMILIES[:1], 1)
    jobs = plan(PlanRequest(families, 1, 8000, detector=preset, tracker=preset))
    episodes = [play_fast(job) for job in jobs]

    def track_again():
        for job, episode in zip(jobs, episodes, strict=True):
            _, tracker = make_system(job.system, rig_of(episode))
            replay = Replay([outcome.detections for outcome in episode.frames])
            list(follow(frames_of(episode), replay, tracker))

    painters = [painted(job) for job in jobs]

    def detect_and_track_again():
        for job, painter in zip(jobs, painters, strict=True):
            detector, tracker = make_system(job.system, painter.film.calibration)
            seen = _stand_in(detector, painter, error_model(job.system.detector))
            list(follow(painter.film.frames(), seen, tracker))

    benchmark.pedantic(lambda: [play_fast(job) for job in jobs], rounds=1, iterations=1)
    frames = sum(len(episode.frames) for episode in episodes)
    played = min(cpu_s(lambda: [play_fast(job) for job in jobs]) for _ in range(repeats))
    tracked = min(cpu_s(track_again) for _ in range(repeats))
    system = min(cpu_s(detect_and_track_again) for _ in range(repeats))
    benchmark.extra_info["episodes of 60 frames per CPU second"] = round(frames / 60 / played, 1)
    benchmark.extra_info["ms per frame"] = round(1e3 * played / frames, 3)
    benchmark.extra_info["all but the tracker over the tracker"] = round(played / tracked - 1, 2)
    benchmark.extra_info["all but detector and tracker over these"] = round(played / system - 1, 2)


def painted(job) -> Painter:
    """All frames of a job, painted already."""
    performance = unjudged(job.scenario, job.seed, job.overrides)
    film = film_of(performance, *_painting(job.system))
    painter = Painter(film, kept=film.frame_count)
    for frame in range(film.frame_count):
        painter.paint(frame)
    return painter


def rig_of(episode):
    return StereoRig(*episode.cameras)


def frames_of(episode):
    return [StereoFrame(i, o.truth.time_s, (None, None)) for i, o in enumerate(episode.frames)]
