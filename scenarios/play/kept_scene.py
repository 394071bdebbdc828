"""What a detector sees in the person-free frames of cached footage: kept apart from detections.

It is most of what a detector learns, and stays when another part of the detector is changed.
"""

from __future__ import annotations

import numpy as np

from pjpdaf.detector.alignment import Alignment
from pjpdaf.detector.blob_detector import BlobDetector
from pjpdaf.detector.exposure import Exposure
from pjpdaf.detector.guidance import ScopedDetector
from pjpdaf.detector.still_scene import StillScene, still_scene
from scenarios.cache.array_file import Arrays
from scenarios.cache.derived import DerivedCache
from scenarios.cache.folder import Kind
from scenarios.cache.key import FootageKey, scene_key
from scenarios.cache.settings import CacheSettings
from scenarios.play.footage import Footage


class KeptScene:
    """The place of an episode's still scene in the cache.

    key: of the footage, whose background is learnt.
    """

    def __init__(self, settings: CacheSettings, key: FootageKey, footage: Footage) -> None:
        self._store, self._key, self._footage = DerivedCache(settings, Kind.SCENES), key, footage

    def learnt(self, detector: ScopedDetector) -> ScopedDetector:
        """Return the detector with the footage's background learnt. Raises as its `learn`."""
        background = self._footage.background()
        if not isinstance(detector, BlobDetector):
            return detector.learn(background)
        adapt, cameras = detector.adaptation, self._footage.calibration.cameras
        parts = {"smooth_noise": adapt.smooth_noise, "align_views": adapt.align_views}
        key = scene_key(self._key, self._footage.renderer, **parts)
        arrays = self._store.read(key)
        if arrays is not None:
            try:
                return detector.learn(background, scene_from_arrays(arrays, len(cameras)))
            except ValueError:
                self._store.drop(key)
        scene = still_scene(background, cameras, **parts)
        learnt = detector.learn(background, scene)
        self._store.write(key, scene_to_arrays(scene))
        return learnt


def scene_to_arrays(scene: StillScene) -> Arrays:
    """The blur of each view; rotation and deviations of the alignment, and its points, or none."""
    there = [] if scene.alignment is None else [scene.alignment]
    turns = [(a.rotation, a.deviations) for a in there]
    return {
        "blurs_px": np.array([exposure.blur_px for exposure in scene.exposures], np.float64),
        "turns": np.array(turns, np.float64).reshape(-1, 2, 3),
        "points": np.array([a.points for a in there], np.int32),
    }


def scene_from_arrays(arrays: Arrays, views: int) -> StillScene:
    """The inverse of `scene_to_arrays`. Raises ValueError for other arrays."""
    try:
        blurs_px, turns, points = arrays["blurs_px"], arrays["turns"], arrays["points"]
    except KeyError as fault:
        raise ValueError(f"has no {fault}") from fault
    if blurs_px.shape != (views,) or len(points) > 1 or turns.shape != (len(points), 2, 3):
        raise ValueError("is of another number of views")
    found = [Alignment(w, sd, int(n)) for (w, sd), n in zip(turns, points, strict=True)]
    exposures = tuple(Exposure(float(blur_px)) for blur_px in blurs_px)
    return StillScene(exposures, found[0] if found else None)
