"""The verb `track`: detector and tracker on real footage, frame by frame."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import json
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from pjpdaf.calibration import read_rig
from pjpdaf.camera import StereoRig, undistort_picture
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.detector.skin import SkinRange, learn_skin_from_head, learn_skin_range
from pjpdaf.detector.undistortion import UndistortPicture
from pjpdaf.errors import BenchError
from pjpdaf.follow import follow
from pjpdaf.interfaces import AnyTracker, Detector
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.presets.flat import flat_values
from pjpdaf.presets.override import override, with_values
from pjpdaf.presets.registry import PRESETS, find_preset
from pjpdaf.sources import (
    FOLDER_RATE_HZ,
    Video,
    open_source,
    picture_pairs,
    read_picture,
    stereo_frames,
)
from reports.footage.status_table import status_table
from reports.footage.track_page import TrackInfo, track_page
from reports.footage.track_record import TrackRecord
from reports.footage.tracks import TrackWriter
from reports.page.templating import write_text
from reports.pictures.film import FilmWriter
from reports.pictures.overlay import encode_jpeg, overlay_picture
from reports.run.provenance import provenance
from scenarios.console.folder import written_whole
from scenarios.console.interrupts import Interrupted, Interrupts, interrupts
from scenarios.console.progress import progress_bar
from scenarios.execute.isolated import allow_plug_ins_from_here
from scenarios.play.settings import read_settings

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
HEAD = "head"  # as --skin-sample: learn from the head in the first frames
HEAD_FRAMES = 30
BROAD_SKIN = SkinRange((340.0, 50.0), (0.1, 0.85), 0.15)  # anyone's, in any usual light
LARGE_BASELINE_M = 1.0  # two cameras that see one table are nearer


@dataclass(frozen=True)
class TrackRequest:
    """What the command line asked for; None = not given."""

    left: Path
    right: Path
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


@dataclass(frozen=True, eq=False)
class Plan:
    """A request that has been checked: everything but the pictures themselves."""

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


def track(request: TrackRequest) -> None:
    """Track, save, print.

    Raises BenchError, for a fault in mid-footage after all before it is saved; Interrupted after
    a signal, likewise; KeyboardInterrupt, and nothing is saved, after a second one while frames
    are still tracked.
    """
    console = Console(stderr=True)

    def say(words: str) -> None:
        console.print(words, markup=False, highlight=False, soft_wrap=True)

    with written_whole(request.out) as part:
        plan = plan_of(request, say)
        with interrupts() as arrived:
            with arrived.raising(at=2):
                with console.status("learning the background"):
                    plan = _learnt(plan, say)
                record, film, fault = _follow(plan, part, console, say, arrived)
            facts = _facts(plan, film, complete=not arrived.arrived and fault is None)
            write_text(part / "report.html", track_page(record, facts))
            _write_json(part / "track.json", plan, record, facts)
    out = Console()
    out.print(status_table(record))
    for line in (
        f"{record.frames} stereo frames, {record.seconds:.1f} s, "
        f"{record.missing_pictures} pictures missing. {record.verdict()}",
        f"tracks: {request.out / 'tracks.csv'}",
        f"film:   {request.out / film.name}" if film else "film:   none",
        f"report: {request.out / 'report.html'}",
    ):
        out.print(line, markup=False, highlight=False, soft_wrap=True)
    kept = f"the first {record.frames} frames are saved in {request.out}"
    if fault is not None:
        raise fault.reworded(f"{str(fault).rstrip('.')}; {kept}")
    if arrived.arrived:
        raise Interrupted(f"interrupted: {kept}")


def plan_of(request: TrackRequest, say: Callable[[str], None]) -> Plan:
    """Everything that can be wrong is found here. Raises BenchError."""
    allow_plug_ins_from_here(request.detector, request.tracker)
    settings = read_settings(request.settings)
    for key in settings.scenario:
        raise BenchError(f"--set {key}: footage has only detector.NAME and tracker.NAME to change")
    _check_background(request)
    if request.fps is not None and not 0 < request.fps <= 1000:
        raise BenchError(f"--fps must be above 0 and at most 1000, got {request.fps:g}")
    size_px = _first_size(request)
    rig = read_rig(*request.calibration, size_px=size_px, unit_m=unit_of(request.unit))
    baseline_m = float((rig.T @ rig.T) ** 0.5)
    if baseline_m > LARGE_BASELINE_M:
        say(
            f"{request.calibration[1]}: the cameras are {baseline_m:.2f} m apart; if T is not in "
            "metres, give --unit mm, or the side of the board's square in metres."
        )
    learnt = _skin(request.skin_sample)
    detector_settings = {**learnt, **settings.detector}
    detector = make_detector(request.detector, rig.cameras, detector_settings)
    tracker = make_tracker(request.tracker, rig.cameras, settings.tracker)
    parameters: dict[str, Any] = {"detector": request.detector, "tracker": request.tracker}
    if request.detector in PRESETS:
        chosen = override(find_preset(request.detector), detector_settings).detector
        parameters |= {f"detector.{key}": value for key, value in flat_values(chosen).items()}
    if request.tracker in PRESETS:
        used = override(find_preset(request.tracker), settings.tracker).tracker
        parameters |= {f"tracker.{key}": value for key, value in flat_values(used).items()}
    changed = {f"detector.{key}" for key in detector_settings}
    changed |= {f"tracker.{key}" for key in settings.tracker}
    left = open_source(request.left)
    own_hz = left.rate_hz if isinstance(left, Video) and left.rate_hz else FOLDER_RATE_HZ
    counts = [s.count for s in (left, open_source(request.right))]
    return Plan(
        request,
        rig,
        request.fps or own_hz,
        max(counts) if all(counts) else None,
        detector,
        tracker,
        parameters,
        {key: parameters[key] for key in changed if key in parameters},
    )


def unit_of(words: str) -> float:
    """Length [m] of the calibration's unit: m, cm, mm, in, or a number of metres."""
    if words in UNITS_M:
        return UNITS_M[words]
    try:
        length_m = float(words)
    except ValueError:
        length_m = 0.0
    if not 0 < length_m < 1000:
        raise BenchError(
            f"--unit must be one of {', '.join(UNITS_M)} or a number of metres, got {words!r}"
        )
    return length_m


def _check_background(request: TrackRequest) -> None:
    folders = (request.background_left, request.background_right)
    first = request.background_first
    if first is None and folders == (None, None):
        raise BenchError(
            "No background: give --background-left and --background-right, person-free pictures of "
            "each view, or --background-first N where the footage begins with N such frames."
        )
    if first is not None and folders != (None, None):
        raise BenchError("Give --background-first or the background folders, not both.")
    if first is None and None in folders:
        raise BenchError("Give both --background-left and --background-right.")
    if first is not None and first < 2:
        raise BenchError(f"--background-first must be at least 2, got {first}")


def _first_size(request: TrackRequest) -> tuple[int, int]:
    """Width and height of the left view's first readable picture."""
    if request.left.resolve() == request.right.resolve():
        raise BenchError(f"--left and --right are the same: {request.left}")
    # Opens both: a wrong path, an empty folder or unlike lengths are found before anything else.
    for pair in picture_pairs(request.left, request.right):
        picture = pair.pictures[0]
        if picture is not None:
            return picture.shape[1], picture.shape[0]
    raise BenchError(f"{request.left}: no picture in it can be read.")


def _skin(sample: Path | None) -> dict[str, Any]:
    """Detector parameters from a picture of skin."""
    if sample is None or sample == Path(HEAD):
        return {}
    if not sample.is_file():
        raise BenchError(f"{sample}: no such skin sample; give a picture cropped to skin.")
    picture = read_picture(sample)
    if picture is None:
        raise BenchError(f"{sample}: cannot be read as a picture.")
    try:
        skin = learn_skin_range(picture)
    except BenchError as fault:
        raise fault.reworded(f"{sample}: {fault}") from None
    return asdict(skin)


def _learnt(plan: Plan, say: Callable[[str], None]) -> Plan:
    """The plan with a detector that knows scene and skin. Raises BenchError."""
    detector = _with_background(plan, say)
    if plan.request.skin_sample != Path(HEAD):
        return dataclasses.replace(plan, detector=detector)
    if not isinstance(detector, SkinDetector):
        raise BenchError(f"--skin-sample {HEAD} is of the presets' detector; give a picture.")
    values = asdict(_skin_of_head(plan, detector))
    given = read_settings(plan.request.settings).detector
    values = {key: value for key, value in values.items() if key not in given}
    parameters = with_values(detector.parameters, values)
    named = {f"detector.{key}": value for key, value in values.items()}
    return dataclasses.replace(
        plan,
        detector=dataclasses.replace(detector, parameters=parameters),
        parameters={**plan.parameters, **named},
        changed={**plan.changed, **named},
    )


def _skin_of_head(plan: Plan, detector: SkinDetector) -> SkinRange:
    """Skin range from the highest skin-like thing that is not background (thesis 3.6)."""
    request = plan.request
    start = request.background_first or 0
    frames = stereo_frames(request.left, request.right, plan.rate_hz, plan.sizes_px)
    wide = dataclasses.replace(detector.parameters, skin=BROAD_SKIN)
    broad = dataclasses.replace(detector, parameters=wide, keep_masks=True)
    whole = isinstance(detector.parameters.undistort, UndistortPicture)
    pictures, masks = [], []
    for frame in itertools.islice(frames, start, start + HEAD_FRAMES):
        for camera, picture, seen in zip(
            plan.rig.cameras, frame.pictures, broad(frame), strict=True
        ):
            if picture is not None and seen.mask is not None:
                pictures.append(undistort_picture(camera, picture) if whole else picture)
                masks.append(seen.mask)
    return learn_skin_from_head(pictures, BROAD_SKIN, masks)


def _with_background(plan: Plan, say: Callable[[str], None]) -> Detector:
    """The detector with the person-free scene. Raises BenchError."""
    request = plan.request
    if request.background_first is not None:
        wanted = request.background_first
        if plan.total is not None and wanted > plan.total:
            raise BenchError(
                f"--background-first {wanted}: the footage has only {plan.total} frames"
            )
        # Silent: the same pictures are named when they are tracked.
        frames = stereo_frames(request.left, request.right, plan.rate_hz, plan.sizes_px)
        return plan.detector.learn(itertools.islice(frames, wanted))
    left, right = request.background_left, request.background_right
    assert left is not None
    assert right is not None
    # Each view learns for itself: unlike lengths do no harm.
    return plan.detector.learn(
        stereo_frames(left, right, plan.rate_hz, plan.sizes_px, say, shortest=True)
    )


def _follow(
    plan: Plan, part: Path, console: Console, say: Callable[[str], None], arrived: Interrupts
) -> tuple[TrackRecord, Path | None, BenchError | None]:
    """Detect and track all frames.

    Returns the record, the film, and the fault of the input that ended the footage early, if any.
    """
    ended_by: BenchError | None = None
    request, cameras = plan.request, plan.rig.cameras
    record = TrackRecord(1 / plan.rate_hz)
    with progress_bar(console) as progress:
        task = progress.add_task("tracking", total=plan.total)
        footage = stereo_frames(request.left, request.right, plan.rate_hz, plan.sizes_px, say)
        frames = itertools.takewhile(lambda _: not arrived.arrived, footage)
        with (
            closing(TrackWriter(part, cameras)) as tracks,
            closing(FilmWriter(part, "overlay", plan.rate_hz)) as film,
        ):
            try:
                for step in follow(frames, plan.detector, plan.tracker):
                    frame, detections, estimates = step.frame, step.detections, step.estimates
                    sheet = overlay_picture(frame, cameras, detections, estimates)
                    tracks.add(frame.index, frame.time_s, estimates)
                    film.add(sheet)
                    record.add(frame, detections, estimates, functools.partial(encode_jpeg, sheet))
                    progress.update(task, advance=1)
            except BenchError as fault:
                if record.frames == 0:
                    raise
                ended_by = fault  # what was tracked before it is kept
    if record.frames == 0:
        raise Interrupted("interrupted before any frame was tracked; nothing saved")
    return record, film.path, ended_by


def _facts(plan: Plan, film: Path | None, complete: bool) -> TrackInfo:
    request = plan.request
    background = (
        f"the first {request.background_first} frames"
        if request.background_first is not None
        else f"{request.background_left} and {request.background_right}"
    )
    return TrackInfo(
        title=f"Tracks: {request.out.absolute().name}",
        complete=complete,
        film=film,
        rig=plan.rig,
        sources=(
            ("left", str(request.left)),
            ("right", str(request.right)),
            ("background", background),
            ("calibration", " and ".join(map(str, request.calibration))),
            ("frames a second", f"{plan.rate_hz:g}"),
        ),
        parameters=plan.parameters,
        changed=plan.changed,
        provenance=provenance(request.argv),
    )


def _write_json(path: Path, plan: Plan, record: TrackRecord, facts: TrackInfo) -> None:
    content = {
        "kind": "pjpdaf-bench track",
        "complete": facts.complete,
        "frames": record.frames,
        "rate_hz": plan.rate_hz,
        "missing_pictures": record.missing_pictures,
        "first_tracked_frame": record.first_frame,
        "targets": {line.target: dict(line.frames) for line in record.summaries()},
        "sources": dict(facts.sources),
        "parameters": dict(plan.parameters),
        "changed": sorted(plan.changed),
        "provenance": dict(facts.provenance),
    }
    write_text(path, json.dumps(content, indent=1, ensure_ascii=False, default=str) + "\n")
