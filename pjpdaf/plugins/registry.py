"""Detectors and trackers by name: presets, entry points, 'module:factory'."""

from __future__ import annotations

import importlib
import sysconfig
import traceback
from collections.abc import Callable, Iterable, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, cast

from pjpdaf.camera import Camera
from pjpdaf.detector.adaptation import BlobDetectorParameters
from pjpdaf.errors import BenchError, did_you_mean
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detector
from pjpdaf.presets.flat import flat_names
from pjpdaf.presets.override import override
from pjpdaf.presets.registry import PRESETS, find_preset
from pjpdaf.printable import printable
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.tracker import HypothesisTracker
from pjpdaf.tracker.parameters import TrackerParameters

DETECTORS = "pjpdaf_bench.detectors"
TRACKERS = "pjpdaf_bench.trackers"

Factory = Callable[[tuple[Camera, ...]], Any]

_OURS = str(Path(__file__).parents[1])
_LIBRARIES = (sysconfig.get_path("stdlib"), sysconfig.get_path("purelib"), "<")


class PlugInError(BenchError):
    """A detector or tracker that cannot be loaded or built."""


class NoSuchPlugIn(PlugInError):
    """There is no detector or tracker of this name."""


def describe_exception(fault: BaseException) -> str:
    """Describe an exception of a user's code in one line: type, text, file and line number."""
    try:
        # Of a BenchError the text as it was raised, before its line breaks were escaped.
        raised = super(BenchError, fault).__str__() if isinstance(fault, BenchError) else str(fault)
        text = printable(" ".join(raised.split()))
    except Exception:  # of their own __str__
        text = ""
    stack = traceback.extract_tb(fault.__traceback__)[1:]  # the first is the caller's `try`
    theirs = [f for f in stack if not f.filename.startswith((_OURS, *_LIBRARIES))]
    # Where all of it is installed, the deepest place is all there is.
    last = (theirs or stack)[-1:]
    place = f" ({Path(last[0].filename).name}:{last[0].lineno})" if last else ""
    return f"{type(fault).__name__}{': ' if text else ''}{text[:200]}{place}"


def plug_in_names(group: str) -> tuple[str, ...]:
    """Names of presets and entry points, for the group DETECTORS or TRACKERS."""
    return tuple(sorted({*PRESETS, *(point.name for point in entry_points(group=group))}))


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
    factory = _factory(kind, group, name)
    try:
        plug_in = factory(cameras)
    except BenchError:
        raise
    except (Exception, SystemExit) as fault:
        cause = describe_exception(fault)
        raise PlugInError(f"The {kind} {name!r} cannot be built: {cause}.") from fault
    missing = [method for method in methods if not callable(getattr(plug_in, method, None))]
    if missing:
        raise PlugInError(f"The {kind} {name!r} lacks {', '.join(missing)}; see pjpdaf.interfaces.")
    return plug_in


def _factory(kind: str, group: str, name: str) -> Factory:
    factory = _entry_point(kind, group, name) or _attribute(kind, group, name)
    if not callable(factory):
        raise PlugInError(f"The {kind} {name!r} is no function of the cameras.")
    return cast(Factory, factory)


def _entry_point(kind: str, group: str, name: str) -> object | None:
    """Load an installed entry point; None where there is no such entry point."""
    for point in entry_points(group=group):
        if point.name == name:
            try:
                loaded: object = point.load()
            except (Exception, SystemExit) as fault:
                cause = describe_exception(fault)
                raise PlugInError(f"The {kind} {name!r} cannot be loaded: {cause}.") from fault
            return loaded
    return None


def _attribute(kind: str, group: str, name: str) -> object:
    """Import the object that 'module:factory' names."""
    module_name, colon, attribute = name.partition(":")
    if not colon:
        raise NoSuchPlugIn(
            f"No {kind} {name!r}.{did_you_mean(name, plug_in_names(group))} "
            "A factory of your own is written module:factory."
        )
    cannot = f"The {kind} {name!r} cannot be imported"
    try:
        module = importlib.import_module(module_name)
    except (ImportError, ValueError) as fault:
        gone = isinstance(fault, ModuleNotFoundError) and fault.name == module_name
        raise (NoSuchPlugIn if gone else PlugInError)(f"{cannot}: {fault}.") from fault
    except (Exception, SystemExit) as fault:  # from code that runs when their module is imported
        raise PlugInError(f"{cannot}: {describe_exception(fault)}.") from fault
    if not hasattr(module, attribute):
        public = [w for w, value in vars(module).items() if callable(value) and w[0] != "_"]
        raise NoSuchPlugIn(f"No {attribute!r} in {module_name!r}.{did_you_mean(attribute, public)}")
    return getattr(module, attribute)
