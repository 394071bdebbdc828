"""Detectors and trackers by name: presets, entry points, 'module:factory'."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, cast

from pjpdaf.camera import Camera
from pjpdaf.detector.adaptation import BlobDetectorParameters
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detector
from pjpdaf.plugins.loading import (
    PlugInError,
    call_plug_in,
    entry_point_names,
    find_factory,
)
from pjpdaf.presets.flat import flat_names
from pjpdaf.presets.override import override
from pjpdaf.presets.registry import PRESETS, find_preset
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.tracker import HypothesisTracker
from pjpdaf.tracker.parameters import TrackerParameters

DETECTORS = "pjpdaf_bench.detectors"
TRACKERS = "pjpdaf_bench.trackers"

Factory = Callable[[tuple[Camera, ...]], Any]


def plug_in_names(group: str) -> tuple[str, ...]:
    """Names of presets and entry points, for the group DETECTORS or TRACKERS."""
    return tuple(sorted({*PRESETS, *entry_point_names(group)}))


def make_tracker(
    name: str, cameras: tuple[Camera, ...], overrides: Mapping[str, object] | None = None
) -> AnyTracker:
    """Make a tracker: a preset's, an entry point of the group TRACKERS, or 'module:factory'.

    overrides: KEY=VALUE for a preset (`pjpdaf.presets.override`); keys of the detector are
    checked and left to `make_detector`. Raises BenchError.
    """
    if name in PRESETS:
        parameters = override(find_preset(name), overrides or {}, PRESETS.values()).tracker
        if isinstance(parameters, HypothesisParameters):
            return HypothesisTracker(cameras, parameters)
        return PJPDAF(cameras, parameters)
    _refuse_overrides("tracker", name, overrides, flat_names(TrackerParameters))
    methods = ("start", "step", "estimates", "predict")
    return cast(AnyTracker, _build("tracker", TRACKERS, name, cameras, methods))


def make_detector(
    name: str,
    cameras: tuple[Camera, ...],
    overrides: Mapping[str, object] | None = None,
    background: Iterable[StereoFrame] | None = None,
) -> Detector:
    """Make a detector: a preset's, an entry point of the group DETECTORS, or 'module:factory'.

    background: person-free frames to learn from at once. Otherwise as `make_tracker`.
    """
    if name in PRESETS:
        # Late: trackers do not need OpenCV's k-means.
        from pjpdaf.detector.blob_detector import BlobDetector
        from pjpdaf.detector.detector import SkinDetector

        preset = override(find_preset(name), overrides or {}, PRESETS.values())
        detector: Detector = SkinDetector(cameras, preset.detector)
        if isinstance(preset.tracker, HypothesisParameters):
            detector = BlobDetector.of(cameras, preset.detector)
    else:
        _refuse_overrides("detector", name, overrides, flat_names(BlobDetectorParameters))
        detector = cast(
            Detector, _build("detector", DETECTORS, name, cameras, ("learn", "__call__"))
        )
    return detector if background is None else detector.learn(background)


def _refuse_overrides(
    kind: str, name: str, overrides: Mapping[str, object] | None, fields: tuple[str, ...]
) -> None:
    """Raise PlugInError for KEY=VALUE of this kind; those of the other kind are checked there."""
    mine = [key for key in overrides or {} if key in fields or key.startswith(f"{kind}.")]
    if mine:
        raise PlugInError(
            f"The {kind} {name!r} is a plug-in and takes no parameters, got {', '.join(mine)}."
        )


def _build(
    kind: str, group: str, name: str, cameras: tuple[Camera, ...], methods: tuple[str, ...]
) -> object:
    factory = find_factory(kind, group, name, PRESETS, " of the cameras")
    plug_in: object = call_plug_in(f"The {kind} {name!r} cannot be built:", factory, cameras)
    missing = [method for method in methods if not callable(getattr(plug_in, method, None))]
    if missing:
        raise PlugInError(f"The {kind} {name!r} lacks {', '.join(missing)}; see pjpdaf.interfaces.")
    return plug_in
