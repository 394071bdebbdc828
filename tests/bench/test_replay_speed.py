"""What an episode costs on footage in the cache, against rendering it. Ratios within one run.

Run with `pytest tests/bench --benchmark-enable`.
"""

import time
from dataclasses import replace

import pytest

from reports.run.rows import rows_of
from scenarios.cache.folder import CacheFolder, Kind
from scenarios.cache.report import required_settings
from scenarios.cache.settings import FOLDER_VARIABLE
from scenarios.play.job import Job, System
from scenarios.play.play import play_complete
from scenarios.spec.names import load_scenario

JOB = Job(load_scenario("cross"), 100, {"frames": 12}, System(), keep_film=True)
OTHER_TRACKER = replace(JOB, system=System(tracker_settings={"miss": "8"}))


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    """The cache, with an episode that has warmed up all that is made once a process."""
    folder = tmp_path_factory.mktemp("replays") / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(folder))
        play_complete(JOB)
        yield CacheFolder(required_settings())


def without(cache, *kinds):
    """Remove these entries."""
    for entry in cache.entries():
        if entry.kind in kinds:
            entry.path.unlink()


def played(job, replayed, kept):
    episode = play_complete(job)
    assert (episode.replayed, episode.detections_kept) == (replayed, kept)
    rows_of(episode)


def rendered(cache):
    without(cache, *Kind)
    played(JOB, replayed=False, kept=False)


def with_another_detector(cache):
    """As if it were another, but for what it sees in the empty room."""
    without(cache, Kind.DETECTIONS)
    played(JOB, replayed=True, kept=False)


def with_another_tracker(cache):
    played(OTHER_TRACKER, replayed=True, kept=True)


WAYS = (rendered, with_another_detector, with_another_tracker)


@pytest.mark.parametrize("way", WAYS, ids=lambda way: way.__name__)
def test_an_episode(benchmark, cache, way):
    benchmark.group = "an episode of 12 frames"
    benchmark.pedantic(way, args=(cache,), rounds=3)


@pytest.mark.long
def test_replays_are_cheaper_by_far(cache):
    """CPU time, which other processes do not change much; the bounds are half of what is usual."""

    def cpu_s(way):
        start = time.process_time()
        way(cache)
        return time.process_time() - start

    rounds = [[cpu_s(way) for way in WAYS] for _ in range(3)]
    rendered_s, detected_s, tracked_s = map(min, zip(*rounds, strict=True))
    assert rendered_s > 2 * detected_s
    assert rendered_s > 5 * tracked_s
