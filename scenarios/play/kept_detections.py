"""Detections of footage that is in the cache: kept, and given to another tracker."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

from pjpdaf.detector.guidance import ScopedDetector
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Detector, Estimates
from scenarios.cache.answers import Answer, answers_from_arrays, answers_to_arrays
from scenarios.cache.derived import DerivedCache
from scenarios.cache.folder import Kind
from scenarios.cache.key import detections_key
from scenarios.play.footage import Footage, footage_cache, key_of
from scenarios.play.job import Job
from scenarios.play.kept_scene import KeptScene
from sim.recording.recorder import RecordedSimulation
from sim.recording.recording import Recording
from sim.truth import Truth

MOST_ANSWERS = 8  # to a frame, to predictions that differ so much


class KeptDetections:
    """A `Detector` whose answers are kept: what was asked before is not detected again.

    detector: one without memory, which has learnt no background yet; learnt: gives the one that has
    learnt the footage's, where no kept answer holds and pictures are looked at. answers: kept
    before, and after a run all; added: number of new ones; reused_s: by frame, the time that a
    reused one took [s].
    """

    def __init__(
        self,
        detector: ScopedDetector,
        learnt: Callable[[], ScopedDetector],
        answers: Mapping[int, list[Answer]],
    ) -> None:
        self._detector, self._learnt_here = detector, learnt
        self._learnt: ScopedDetector | None = None
        self.answers = {frame: list(kept) for frame, kept in answers.items()}
        self.added = 0
        self.reused_s: dict[int, float] = {}

    def learn(self, background: Iterable[StereoFrame]) -> Detector:
        """Learn another background than the footage's."""
        self._learnt = self._detector.learn(background)
        return self

    def learn_footage(self) -> ScopedDetector:
        """Learn the footage's background at once."""
        self._learnt = self._learnt_here()
        return self._learnt

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the kept answer to this frame and prediction, or the detector's, and keep it."""
        kept = self.answers.setdefault(frame.index, [])
        guidance = self._detector.guidance(predicted)
        for answer in kept:
            if answer.holds(guidance):
                self.reused_s[frame.index] = answer.detect_s
                return answer.detections
        learnt = self._learnt or self.learn_footage()
        started = time.perf_counter()
        detections, scopes = learnt.detect(frame, predicted)
        answer = Answer(detections, scopes, time.perf_counter() - started)
        kept.append(answer)
        del kept[:-MOST_ANSWERS]
        self.added += 1
        return answer.detections


class Watched(NamedTuple):
    """What the loop is given: a detector that knows the background, frames with their truth.

    reused_s: of frames whose detections were kept, the time that they took once [s].
    """

    detector: Detector
    frames: Iterator[tuple[StereoFrame, Truth]]
    reused_s: Mapping[int, float]


@contextmanager
def watched(job: Job, footage: Footage, detector: Detector) -> Iterator[Watched]:
    """Footage and a detector that learns its background.

    Where the footage is in the cache, so are a preset's detections from then on: they are read from
    there, pictures only where somebody looks at them, and new ones go there at the end of the
    block. No key can know all the code of a plug-in, or what it remembers: it detects anew.
    """
    cache = footage_cache(job)
    recorded = isinstance(footage, Recording | RecordedSimulation)
    if cache is None or not recorded or not isinstance(detector, ScopedDetector):
        yield Watched(detector.learn(footage.background()), footage.frames(), {})
        return
    store = DerivedCache(cache.settings, Kind.DETECTIONS)
    key = detections_key(key_of(job), footage.renderer, detector.recipe)
    scene = KeptScene(cache.settings, key_of(job), footage)
    kept = KeptDetections(detector, partial(scene.learnt, detector), _read(store, key))
    if not kept.answers:
        kept.learn_footage()
    lazily = kept.answers and isinstance(footage, Recording)
    frames = footage.frames_on_demand() if lazily else footage.frames()
    yield Watched(kept, frames, kept.reused_s)
    if kept.added:
        store.write(key, answers_to_arrays(kept.answers))


def _read(store: DerivedCache, key: Mapping[str, object]) -> Mapping[int, list[Answer]]:
    """The kept answers of a key, none where there are none or they are damaged."""
    arrays = store.read(key)
    try:
        return {} if arrays is None else answers_from_arrays(arrays)
    except ValueError:
        store.drop(key)
        return {}
