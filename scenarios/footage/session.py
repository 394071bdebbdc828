"""A checked request of `track`: rig, detector, tracker and frame rate."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.calibration import read_rig, view_order_doubt
from pjpdaf.camera import StereoRig
from pjpdaf.detector.external import ExternalDetector
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import AnyTracker, Detector
from pjpdaf.layouts import Layout
from pjpdaf.picture_files import is_grey, stored_fault
from pjpdaf.plugins.loading import allow_plug_ins_from_here
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.presets.flat import flat_values
from pjpdaf.presets.override import override
from pjpdaf.presets.registry import PRESETS, find_preset
from pjpdaf.sources import (
    PictureFolder,
    open_source,
    own_rate_hz,
    picture_pairs,
    stereo_frames,
)
from scenarios.footage.skin_sample import skin_of_sample
from scenarios.play.lag import check_lag, check_smoother
from scenarios.play.settings import read_settings
from scenarios.tables.detections import read_detections, read_min_score

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
LOOKED_AT = 5  # pictures of the footage, before anything is learnt
LARGE_BASELINE_M = 1.0  # two cameras that see one table are nearer


@dataclass(frozen=True)
class TrackRequest:
    """The options of `track`; None = not given.

    layout: where both views are in each picture of `left`, whose `right` is None; shortest: of
    views of unlike length the rest is left out. Instead of a background of its own: no_background,
    none at all; background_from_footage, what is seen most of the time.
    """

    left: Path
    right: Path | None
    calibration: tuple[Path, Path]
    background_left: Path | None
    background_right: Path | None
    background_first: int | None
    fps: float | None
    preset: str
    detector: str
    tracker: str
    settings: tuple[str, ...]
    skin_sample: Path | None
    unit: str
    out: Path
    argv: tuple[str, ...]
    layout: Layout = "separate"
    shortest: bool = False
    no_background: bool = False
    background_from_footage: bool = False
    detections: Path | None = None
    lag: int = 0


@dataclass(frozen=True, eq=False)
class TrackSession:
    """A checked request, with all but the pictures themselves.

    total: stereo frames of the footage, None if unknown; parameters: values in force, by name;
    changed: those of them that the user changed, or that a sample of skin gave.
    """

    request: TrackRequest
    rig: StereoRig
    rate_hz: float
    total: int | None
    detector: Detector
    tracker: AnyTracker
    parameters: Mapping[str, Any]
    changed: Mapping[str, Any]

    @property
    def sizes_px(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Width and height of each view."""
        left, right = self.rig.cameras
        return (left.width_px, left.height_px), (right.width_px, right.height_px)

    def frames(self, warn: Callable[[str], None] | None = None) -> Iterator[StereoFrame]:
        """The footage. warn: takes a message for each picture that is missing or damaged."""
        request = self.request
        return stereo_frames(
            request.left,
            request.right,
            request.fps,
            self.sizes_px,
            warn,
            request.shortest,
            request.layout,
        )


def prepare_session(request: TrackRequest, warn: Callable[[str], None]) -> TrackSession:
    """Check a request and build its session. Raises BenchError for any fault of the request."""
    allow_plug_ins_from_here(request.detector, request.tracker)
    settings = read_settings(request.settings)
    check_lag(request.lag)
    for key in settings.scenario:
        raise BenchError(f"--set {key}: footage has only detector.NAME and tracker.NAME to change")
    size_px = _first_size(request)  # what the footage lacks comes before all that goes with it
    if request.detections is None:
        _check_background(request)
    else:
        _refuse_detector_options(request)
    if request.fps is not None and not 0 < request.fps <= 1000:
        raise BenchError(f"--fps must be above 0 and at most 1000, got {request.fps:g}")
    rig = read_rig(*request.calibration, size_px=size_px, unit_m=parse_unit(request.unit))
    baseline_m = float((rig.T @ rig.T) ** 0.5)
    if baseline_m > LARGE_BASELINE_M:
        warn(
            f"{request.calibration[1]}: the cameras are {baseline_m:.2f} m apart; if T is not in "
            "metres, give --unit mm, or the side of the board's square in metres."
        )
    doubt = view_order_doubt(rig)
    if doubt:
        warn(f"{request.calibration[1]}: {doubt}.")
    learnt = skin_of_sample(request.skin_sample)
    detector_settings = {**learnt, **settings.detector}
    detector: Detector
    if request.detections is None:
        detector = make_detector(request.detector, rig.cameras, detector_settings)
    else:
        detector = _external_detector(request.detections, rig, settings.detector)
    tracker = make_tracker(request.tracker, rig.cameras, settings.tracker)
    check_smoother(request.tracker, tracker, request.lag)
    parameters: dict[str, Any] = {"detector": request.detector, "tracker": request.tracker}
    if request.detections is None and request.detector in PRESETS:
        chosen = override(find_preset(request.detector), detector_settings).detector
        parameters |= {f"detector.{key}": value for key, value in flat_values(chosen).items()}
    if request.tracker in PRESETS:
        used = override(find_preset(request.tracker), settings.tracker).tracker
        parameters |= {f"tracker.{key}": value for key, value in flat_values(used).items()}
    changed = {f"detector.{key}" for key in detector_settings}
    changed |= {f"tracker.{key}" for key in settings.tracker}
    counts = [open_source(path).count for path in (request.left, request.right) if path]
    return TrackSession(
        request,
        rig,
        request.fps or own_rate_hz(request.left),
        (min if request.shortest else max)(counts) if all(counts) else None,
        detector,
        tracker,
        parameters,
        {key: parameters[key] for key in changed if key in parameters},
    )


def parse_unit(text: str) -> float:
    """Length [m] of the calibration's unit: m, cm, mm, in, or a number of metres."""
    if text in UNITS_M:
        return UNITS_M[text]
    try:
        length_m = float(text)
    except ValueError:
        length_m = 0.0
    if not 0 < length_m < 1000:
        raise BenchError(
            f"--unit must be one of {', '.join(UNITS_M)} or a number of metres, got {text!r}"
        )
    return length_m


def _check_background(request: TrackRequest) -> None:
    folders = (request.background_left, request.background_right)
    first = request.background_first
    given = {
        "the background folders": folders != (None, None),
        "--background-first": first is not None,
        "--no-background": request.no_background,
        "--background-from-footage": request.background_from_footage,
    }
    named = [option for option, is_given in given.items() if is_given]
    if not named:
        raise BenchError(
            "No background: give --background-left and --background-right, person-free pictures of "
            "each view, or --background-first N where the footage begins with N such frames. "
            "Without any: --background-from-footage where the person moves, else --no-background."
        )
    if len(named) > 1:
        raise BenchError(f"Give {' or '.join(named)}, not both.")
    if request.layout == "separate" and any(folders) and None in folders:
        raise BenchError("Give both --background-left and --background-right.")
    if request.layout != "separate" and request.background_right is not None:
        raise BenchError(
            f"--stereo {request.layout}: --background-left has both views; leave "
            "--background-right out."
        )
    if first is not None and first < 2:
        raise BenchError(f"--background-first must be at least 2, got {first}")


def _first_size(request: TrackRequest) -> tuple[int, int]:
    """Width and height of the left view's first readable picture.

    Raises BenchError for footage in which the presets cannot find skin, and says why.
    """
    if request.right is not None and request.left.resolve() == request.right.resolve():
        raise BenchError(f"--left and --right are the same: {request.left}")
    seen: list[np.ndarray] = []
    # Opens both: a wrong path, an empty folder or unlike lengths are reported before anything else.
    pairs = picture_pairs(
        request.left, request.right, shortest=request.shortest, layout=request.layout
    )
    for pair in itertools.islice(pairs, LOOKED_AT):
        seen += [picture for picture in pair.pictures[:1] if picture is not None]
    if not seen:
        raise BenchError(f"{request.left}: no picture in its first {LOOKED_AT} can be read.")
    if request.detections is None and request.detector in PRESETS:
        _check_colours(request.left, seen)
    return seen[0].shape[1], seen[0].shape[0]


def _check_colours(left: Path, pictures: Sequence[np.ndarray]) -> None:
    source = open_source(left)
    if isinstance(source, PictureFolder):
        fault = next(filter(None, map(stored_fault, source.files[:LOOKED_AT])), "")
        if fault:
            raise BenchError(f"{fault}.")
    if is_grey(pictures):
        raise BenchError(
            f"{left}: the pictures are grey: without colour no skin is found. Film in colour, or "
            "give --detections of a detector of your own."
        )


def _external_detector(path: Path, rig: StereoRig, settings: Mapping[str, str]) -> ExternalDetector:
    """The detections of a file for footage of unknown length. Raises BenchError."""
    if path.is_dir():
        raise BenchError(f"{path}: is a folder; `track` takes one file of detections.")
    min_score = read_min_score(settings)
    tables = read_detections(
        path, {"footage": rig.cameras}, {"footage": None}, min_score, "the footage"
    )
    if not tables:
        raise BenchError(f"{path}: has no detections.")
    return ExternalDetector(rig.cameras, tables["footage"])


def _refuse_detector_options(request: TrackRequest) -> None:
    """Raise BenchError for options of a detector that --detections takes the place of."""
    given = {
        "--background-left": request.background_left,
        "--background-right": request.background_right,
        "--background-first": request.background_first,
        "--skin-sample": request.skin_sample,
        "--no-background": request.no_background or None,
        "--background-from-footage": request.background_from_footage or None,
    }
    for option, value in given.items():
        if value is not None:
            raise BenchError(f"{option}: detections come from {request.detections}; leave it out")
