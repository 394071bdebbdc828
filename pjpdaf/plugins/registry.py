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
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.errors import BenchError, did_you_mean
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detector
from pjpdaf.presets.flat import flat_names
from pjpdaf.presets.override import override
from pjpdaf.presets.registry import PRESETS, find_preset
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.parameters import TrackerParameters

DETECTORS = "pjpdaf_bench.detectors"
TRACKERS = "pjpdaf_bench.trackers"

Factory = Callable[[tuple[Camera, ...]], Any]


_OURS = str(Path(__file__).parents[1])
_LIBRARIES = (sysconfig.get_path("stdlib"), sysconfig.get_path("purelib"), "<")


class UnknownPart(BenchError):
    """A detector or tracker that cannot be found, imported or built."""


class NoSuchPart(UnknownPart):
    """Nothing has this name."""


def described(fault: BaseException) -> str:
    """An exception of somebody else's code in one line: type, text, file and line of that code."""
    try:
        text = " ".join(str(fault).split())
    except Exception:  # of their own __str__
        text = ""
    where = traceback.extract_tb(fault.__traceback__)[1:]  # the first is the caller's `try`
    theirs = [f for f in where if not f.filename.startswith((_OURS, *_LIBRARIES))]
    # Where all of it is installed, the deepest place is all there is.
    last = (theirs or where)[-1:]
    place = f" ({Path(last[0].filename).name}:{last[0].lineno})" if last else ""
    return f"{type(fault).__name__}{': ' if text else ''}{text[:200]}{place}"


def names(group: str) -> tuple[str, ...]:
    """Names that `make_detector` or `make_tracker` know, for group DETECTORS or TRACKERS."""
    return tuple(sorted({*PRESETS, *(point.name for point in entry_points(group=group))}))


def make_tracker(
    name: str, cameras: tuple[Camera, ...], overrides: Mapping[str, object] | None = None
) -> AnyTracker:
    """A tracker: a preset's, an entry point of the group TRACKERS, or 'module:factory'.

    overrides: KEY=VALUE for a preset (see `presets.override`); keys of the detector are
    checked and left to `make_detector`. Raises BenchError.
    """
    if name in PRESETS:
        return PJPDAF(cameras, override(find_preset(name), overrides or {}).tracker)
    _refuse_overrides("tracker", name, overrides, flat_names(TrackerParameters))
    part = _build("tracker", TRACKERS, name, cameras, ("start", "step", "estimates", "predict"))
    return cast(AnyTracker, part)


def make_detector(
    name: str,
    cameras: tuple[Camera, ...],
    overrides: Mapping[str, object] | None = None,
    background: Iterable[StereoFrame] | None = None,
) -> Detector:
    """A detector: a preset's, an entry point of the group DETECTORS, or 'module:factory'.

    background: person-free frames to learn from at once. Otherwise as `make_tracker`.
    """
    if name in PRESETS:
        from pjpdaf.detector.detector import (
            SkinDetector,  # late: trackers do not need OpenCV's k-means
        )

        detector: Detector = SkinDetector(
            cameras, override(find_preset(name), overrides or {}).detector
        )
    else:
        _refuse_overrides("detector", name, overrides, flat_names(DetectorParameters))
        detector = cast(
            Detector, _build("detector", DETECTORS, name, cameras, ("learn", "__call__"))
        )
    return detector if background is None else detector.learn(background)


def _refuse_overrides(
    kind: str, name: str, overrides: Mapping[str, object] | None, fields: tuple[str, ...]
) -> None:
    """A plug-in takes no KEY=VALUE; keys of the other part are its business."""
    mine = [key for key in overrides or {} if key in fields or key.startswith(f"{kind}.")]
    if mine:
        raise UnknownPart(
            f"The {kind} {name!r} is a plug-in and takes no parameters, got {', '.join(mine)}."
        )


def _build(
    kind: str, group: str, name: str, cameras: tuple[Camera, ...], methods: tuple[str, ...]
) -> object:
    factory = _factory(kind, group, name)
    try:
        part = factory(cameras)
    except BenchError:
        raise
    except (Exception, SystemExit) as fault:
        raise UnknownPart(f"The {kind} {name!r} cannot be built: {described(fault)}.") from fault
    missing = [method for method in methods if not callable(getattr(part, method, None))]
    if missing:
        raise UnknownPart(f"The {kind} {name!r} lacks {', '.join(missing)}; see pjpdaf.interfaces.")
    return part


def _factory(kind: str, group: str, name: str) -> Factory:
    for point in entry_points(group=group):
        if point.name == name:
            try:
                found = point.load()
            except (Exception, SystemExit) as fault:
                raise UnknownPart(
                    f"The {kind} {name!r} cannot be loaded: {described(fault)}."
                ) from fault
            return _callable(kind, name, found)
    module, colon, factory = name.partition(":")
    if not colon:
        raise NoSuchPart(
            f"No {kind} {name!r}.{did_you_mean(name, names(group))} "
            "A factory of your own is written module:factory."
        )
    try:
        found = importlib.import_module(module)
    except (ImportError, ValueError) as fault:
        gone = isinstance(fault, ModuleNotFoundError) and fault.name == module
        kind_of_fault = NoSuchPart if gone else UnknownPart
        raise kind_of_fault(f"The {kind} {name!r} cannot be imported: {fault}.") from fault
    except (Exception, SystemExit) as fault:  # whatever their module does when it is imported
        raise UnknownPart(f"The {kind} {name!r} cannot be imported: {described(fault)}.") from fault
    if not hasattr(found, factory):
        public = [w for w, value in vars(found).items() if callable(value) and w[0] != "_"]
        raise NoSuchPart(f"No {factory!r} in {module!r}.{did_you_mean(factory, public)}")
    return _callable(kind, name, getattr(found, factory))


def _callable(kind: str, name: str, found: object) -> Factory:
    if not callable(found):
        raise UnknownPart(f"The {kind} {name!r} is no function of the cameras.")
    return cast(Factory, found)
