"""Conformance of a detector: painted pictures of a wall and three discs."""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.answers import fault_of_detections
from pjpdaf.plugins.probe import CheckEnds, Probe
from pjpdaf.plugins.registry import Factory
from pjpdaf.plugins.scenes import cameras_in_front, painted, paths_m

METHODS = ("learn", "__call__")


def check(factory: Factory, probe: Probe) -> None:
    """Check a detector. Raises CheckEnds."""
    points = paths_m(3)
    wall = [painted(None, k, seed=1) for k in range(20)]
    first: list[tuple[Detections, ...]] = []
    second: list[tuple[Detections, ...]] = []
    expected = Estimates(
        points[0], np.tile(1e-4 * np.eye(3), (3, 1, 1)), np.zeros((3, 3)), ("tracked",) * 3
    )
    for answers in (first, second):
        fresh = probe.build(factory, METHODS)
        detector = probe.call("learn", fresh.learn, wall)
        if not callable(detector):
            raise CheckEnds(f"learn: must return a detector, returns {type(detector).__name__}")
        for index, at in enumerate(points):
            for predicted in (None, expected):
                frame = painted(at, index)
                answers.append(_detect(probe, "call", detector, frame, predicted))
    for a, b in zip(first, second, strict=True):
        if not all(np.array_equal(x.centres_px, y.centres_px) for x, y in zip(a, b, strict=True)):
            probe.add("two detectors of the same factory", "differ on the same pictures")
            break
    whole = painted(points[0], 0)
    half = StereoFrame(0, 0.0, (None, whole.pictures[1]))
    label = "call(left picture missing)"
    left, right = _detect(probe, label, detector, half, None)
    if not left.missing or len(left):
        probe.add(label, "must give Detections.none(missing=True) for that view")
    if right.missing:
        probe.add(label, "the right picture is there, but reported as missing")
    _detect(probe, "call(empty scene)", detector, wall[0], None)


def _detect(
    probe: Probe, label: str, detector: Any, frame: StereoFrame, predicted: Estimates | None
) -> tuple[Detections, ...]:
    """Detections of a frame, checked: finite, and inside the picture."""
    cameras = cameras_in_front()
    answer = probe.call(label, detector, frame, predicted)
    probe.end_at(label, fault_of_detections(answer, len(cameras)))
    detections: tuple[Detections, ...] = answer
    for camera, view in zip(cameras, detections, strict=True):
        size = np.array([camera.width_px, camera.height_px])
        if ((view.centres_px < -0.5) | (view.centres_px > size - 0.5)).any():
            probe.add(label, "centres_px lie outside the picture (x, y in pixels)")
    return detections
