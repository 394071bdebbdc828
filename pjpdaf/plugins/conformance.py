"""Does a detector or tracker of somebody's own keep to the protocol (`pjpdaf.interfaces`)?

Small scenes of our own: three targets in front of two cameras, as measurements for a tracker, as
painted pictures for a detector. Every fault is one line: what was called, what is wrong.
"""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project
from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.registry import NoSuchPart, described, make_detector, make_tracker
from pjpdaf.targets import TARGETS

LIMIT_S = 10.0
LONGEST_LIMIT_S = 3600.0
DT_S = 1 / 3
FRAMES = 12
FARTHEST_M = 1e6  # what lies beyond is no place, but a filter that has diverged
FAR_M = 0.3  # an estimate farther from its own target than this follows nothing
_TRACKER_METHODS = ("start", "step", "estimates", "predict")
_DETECTOR_METHODS = ("learn", "__call__")
_SKIN_BGR, _WALL_BGR = (105, 140, 205), (150, 160, 120)

Factory = Callable[[tuple[Camera, ...]], Any]


@dataclass(frozen=True)
class _Fault(Exception):
    """Ends a check: what follows would only repeat it."""

    line: str


def check_named(kind: str, name: str, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """The faults of a plug-in by name: an entry point, or module:factory. kind: tracker, detector.

    Raises BenchError for another kind, NoSuchPart for a name that is not there.
    """
    if kind not in ("tracker", "detector"):
        raise BenchError(f"--kind must be tracker or detector, got {kind!r}")
    if not 0 < limit_s <= LONGEST_LIMIT_S:
        raise BenchError(
            f"--limit must be above 0 and at most {LONGEST_LIMIT_S:g} s, got {limit_s:g}"
        )
    if kind == "tracker":
        return check_tracker(partial(make_tracker, name), limit_s)
    return check_detector(partial(make_detector, name), limit_s)


def check_tracker(factory: Factory, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """All faults of a tracker, none where it keeps to the protocol.

    limit_s: how long one call may take [s]. A call that hangs leaves its thread behind.
    """
    return _faults(_tracker_faults(factory, limit_s))


def check_detector(factory: Factory, limit_s: float = LIMIT_S) -> tuple[str, ...]:
    """All faults of a detector, as `check_tracker`."""
    return _faults(_detector_faults(factory, limit_s))


def cameras_in_front() -> tuple[Camera, Camera]:
    """Two level cameras 1.3 m in front of the person, 90 mm apart, 640x480."""
    K = np.array([[540.0, 0.0, 319.5], [0.0, 540.0, 239.5], [0.0, 0.0, 1.0]])
    R = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
    left, right = (Camera(K, R, -R @ np.array([1.3, y, 1.0]), 640, 480) for y in (-0.045, 0.045))
    return left, right


def paths_m(frames: int = FRAMES, dt_s: float = DT_S) -> Floats:
    """Head, right hand, left hand (frames, 3, 3) [m]: slow, hands 0.24 m and more apart."""
    phase = 0.7 * dt_s * np.arange(frames)
    still = np.zeros(frames)
    head = np.stack([0.05 + still, 0.01 * np.sin(phase), 1.2 + still], axis=1)
    right = np.stack([0.35 + still, -0.2 + 0.05 * np.sin(phase), 0.85 + 0.04 * np.cos(phase)], 1)
    left = np.stack([0.35 + still, 0.2 + 0.04 * np.cos(phase), 0.85 + 0.05 * np.sin(phase)], 1)
    return np.stack([head, right, left], axis=1)


def seen_by(
    cameras: tuple[Camera, ...], points_m: Floats, order: Sequence[int]
) -> tuple[Detections, ...]:
    """What a faultless detector sees of targets (T, 3), each view's blobs in this order (T,)."""
    order = list(order)
    size = np.array([[40.0, 30.0], [22.0, 16.0], [22.0, 16.0]])[order]
    views = []
    for camera in cameras:
        centres = project(camera, points_m)[order]
        ellipses = np.column_stack([centres, size, np.zeros(len(order))])
        covariances = np.tile(4.0 * np.eye(2), (len(order), 1, 1))
        views.append(Detections(centres, covariances, ellipses, np.pi * size.prod(axis=1)))
    return tuple(views)


def _faults(found: Iterator[str]) -> tuple[str, ...]:
    """Every line once, until the check ends."""
    lines: list[str] = []
    try:
        for line in found:
            if line not in lines:
                lines.append(line)
    except _Fault as fault:
        lines.append(fault.line)
    return tuple(lines)


def _call(what: str, limit_s: float, function: Callable[..., Any], *arguments: Any) -> Any:
    """The function's value. Raises _Fault where it raises or does not return in time."""
    done: list[Any] = []
    raised: list[BaseException] = []

    def work() -> None:
        try:
            done.append(function(*arguments))
        except BaseException as fault:
            raised.append(fault)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(limit_s)
    if thread.is_alive():
        raise _Fault(f"{what}: has not returned after {limit_s:g} s")
    if raised:
        if isinstance(raised[0], NoSuchPart):
            raise raised[0]
        if isinstance(raised[0], BenchError):
            raise _Fault(" ".join(str(raised[0]).split()))
        raise _Fault(f"{what}: raises {described(raised[0])}")
    return done[0]


def fault_of_estimates(said: object) -> str:
    """Why this cannot be scored, "" where it can: no `Estimates`, other targets, infinite numbers.

    NaN is a target without a place, and scored as missed.
    """
    if not isinstance(said, Estimates):
        return f"must give an Estimates, gives {type(said).__name__}"
    if len(said.status) != len(TARGETS):
        return f"must have {len(TARGETS)} targets ({', '.join(TARGETS)}), has {len(said.status)}"
    for name in ("positions_m", "covariances_m2", "velocities_mps"):
        if np.isinf(getattr(said, name)).any():
            return f"{name} has infinite values"
    farthest_m = np.nanmax(np.abs(said.positions_m), initial=0.0)
    if farthest_m > FARTHEST_M:
        return f"positions_m has a value of {farthest_m:.2g} m; they are in the world, in metres"
    return ""


def fault_of_step(result: object) -> str:
    """As `fault_of_estimates`, of what a tracker's `step` returns."""
    if not (isinstance(result, tuple) and len(result) == 2):
        return f"must return (state, Estimates), returns {_kind_of(result)}"
    if result[0] is None:
        return "must return a state, returns None"
    return fault_of_estimates(result[1])


def fault_of_detections(seen: object, views: int) -> str:
    """Why a tracker cannot be given this, "" where it can. views: how many cameras there are."""
    if not (isinstance(seen, tuple) and all(isinstance(view, Detections) for view in seen)):
        return f"must give a tuple of Detections, gives {_kind_of(seen)}"
    if len(seen) != views:
        return f"must give {views} views, gives {len(seen)}"
    for view in seen:
        for name in ("centres_px", "covariances_px2", "ellipses", "areas_px"):
            if not np.isfinite(getattr(view, name)).all():
                return f"{name} has NaN or infinite values"
    return ""


def _kind_of(value: object) -> str:
    if not isinstance(value, tuple):
        return type(value).__name__
    return f"({', '.join(type(part).__name__ for part in value[:5])})"


def _built(factory: Factory, methods: tuple[str, ...], limit_s: float) -> Any:
    part = _call("factory(cameras)", limit_s, factory, cameras_in_front())
    missing = [name for name in methods if not callable(getattr(part, name, None))]
    if missing:
        raise _Fault(f"lacks {', '.join(missing)} (pjpdaf.interfaces)")
    return part


# Trackers


def _tracker_faults(factory: Factory, limit_s: float) -> Iterator[str]:
    tracker = _built(factory, _TRACKER_METHODS, limit_s)
    cameras = cameras_in_front()
    nothing = (Detections.none(),) * len(cameras)
    early = _call("start(no detections)", limit_s, tracker.start, nothing)
    if early is not None:
        what = "estimates, started without detections"
        said = _call(what, limit_s, tracker.estimates, early)
        yield from _estimate_faults(what, said, {"waiting", "lost"})
    first = yield from _tracked(tracker, limit_s)
    again = _built(factory, _TRACKER_METHODS, limit_s)
    second: list[Estimates] = []
    try:
        second = yield from _tracked(again, limit_s)
    except _Fault:
        yield "a second tracker of the same factory: fails where the first did not"
        return
    if not all(_equal(a, b) for a, b in zip(first, second, strict=True)):
        yield "two trackers of the same factory: differ on the same detections; must be repeatable"
    yield from _hard_frames(tracker, limit_s)


def _tracked(tracker: Any, limit_s: float) -> Generator[str, None, list[Estimates]]:
    """Follow three slow targets; returns the estimates of all frames."""
    cameras, paths = cameras_in_front(), paths_m()
    rng = np.random.default_rng(0)
    state: Any = None
    said: list[Estimates] = []
    for points in paths:
        seen = seen_by(cameras, points, rng.permutation(len(TARGETS)).tolist())
        if state is None:
            state = _call("start", limit_s, tracker.start, seen)
            if state is None:
                said.append(Estimates.waiting())
                continue
            estimates = _call("estimates", limit_s, tracker.estimates, state)
            yield from _estimate_faults("estimates", estimates)
        else:
            expected = _call("predict", limit_s, tracker.predict, state, DT_S)
            yield from _estimate_faults("predict", expected)
            before = _frozen(state)
            result = _call("step", limit_s, tracker.step, state, seen, DT_S)
            _stop_at("step", fault_of_step(result))
            if before != _frozen(state):
                yield "step: changes the state it was given; must return a new one"
            state, estimates = result
            yield from _estimate_faults("step", estimates)
        said.append(estimates)
        yield from _order_faults(estimates, points)
    if state is None:
        raise _Fault(f"start: no state in {len(paths)} frames of three clear blobs in both views")
    yield from _following_faults(said[-1], paths[-1])
    return said


def _stop_at(what: str, fault: str) -> None:
    if fault:
        raise _Fault(f"{what}: {fault}")


def _order_faults(said: Estimates, truth_m: Floats) -> Iterator[str]:
    """Whether the rows are near the targets, but near each other's."""
    between = np.linalg.norm(said.positions_m[:, None] - truth_m[None], axis=-1)
    if not np.isfinite(between).all() or between.min(axis=1).max() > FAR_M:
        return
    nearest = between.argmin(axis=1).tolist()
    for row, target in enumerate(nearest):
        if row != target and sorted(nearest) == [0, 1, 2]:
            yield (
                f"wrong order of targets: row {row} must be the {TARGETS[row]}, follows the "
                f"{TARGETS[target]}; the order is {', '.join(TARGETS)}"
            )


def _following_faults(said: Estimates, truth_m: Floats) -> Iterator[str]:
    """Whether each row is near its own target in the end; not where only their order is wrong."""
    between = np.linalg.norm(said.positions_m[:, None] - truth_m[None], axis=-1)
    if between.diagonal().max() > FAR_M and not any(_order_faults(said, truth_m)):
        row = int(between.diagonal().argmax())
        yield (
            f"{TARGETS[row]}: is {between[row, row]:.2f} m off after {FRAMES} frames of three "
            f"clear blobs in both views (positions are in the world, in metres)"
        )


def _estimate_faults(
    what: str, said: Any, unplaced: frozenset[str] | set[str] = frozenset({"waiting"})
) -> Iterator[str]:
    """Shapes, finite numbers. unplaced: statuses whose numbers may be NaN."""
    _stop_at(what, fault_of_estimates(said))
    placed = np.array([status not in unplaced for status in said.status])
    for name in ("positions_m", "covariances_m2", "velocities_mps"):
        if not np.isfinite(getattr(said, name)[placed]).all():
            yield f"{what}: {name} has NaN values"
    for P in said.covariances_m2[placed]:
        if np.isfinite(P).all():
            scale = max(1e-12, float(np.abs(P).max()))
            if np.abs(P - P.T).max() > 1e-6 * scale:
                yield f"{what}: covariances_m2 are not symmetric"
            elif np.linalg.eigvalsh(P)[0] < -1e-6 * scale:
                yield f"{what}: covariances_m2 have negative eigenvalues"


def _hard_frames(tracker: Any, limit_s: float) -> Iterator[str]:
    """What real footage brings: no blobs, a missing picture, one blob, uneven time steps."""
    cameras, paths = cameras_in_front(), paths_m()
    whole = seen_by(cameras, paths[0], range(3))
    state = _call("start", limit_s, tracker.start, whole)
    if state is None:  # one that needs more frames has been told so above, or waits for more
        return
    none, missing = Detections.none(), Detections.none(missing=True)
    one = seen_by(cameras, paths[0], [1])
    hard = {
        "no detections": (none, none),
        "a missing picture": (missing, whole[1]),
        "both pictures missing": (missing, missing),
        "one blob": one,
        "one view empty": (whole[0], none),
    }
    for name, seen in hard.items():
        for dt_s in (1 / 30, 1.0):
            what = f"step({name}, dt {dt_s:.2g} s)"
            result = _call(what, limit_s, tracker.step, state, seen, dt_s)
            _stop_at(what, fault_of_step(result))
            yield from _estimate_faults(what, result[1], {"waiting", "lost"})
            state = result[0]


def _frozen(state: Any) -> bytes | str:
    """A copy to compare with; what cannot be pickled is compared by its text."""
    try:
        return pickle.dumps(state)
    except Exception:
        return repr(getattr(state, "__dict__", state))


def _equal(a: Estimates, b: Estimates) -> bool:
    names = ("positions_m", "covariances_m2", "velocities_mps")
    same = all(np.array_equal(getattr(a, n), getattr(b, n), equal_nan=True) for n in names)
    return same and a.status == b.status


# Detectors


def painted(points_m: Floats | None, index: int, seed: int = 0) -> StereoFrame:
    """Both pictures of a wall, with skin-coloured discs where the targets (T, 3) are."""
    rng = np.random.default_rng([seed, index])
    pictures = []
    for camera in cameras_in_front():
        canvas = np.full((480, 640, 3), _WALL_BGR, dtype=np.uint8)
        if points_m is not None:
            for centre, size in zip(project(camera, points_m), (40, 24, 24), strict=True):
                x, y = (int(v) for v in np.round(centre))
                cv2.ellipse(canvas, (x, y), (size, round(0.8 * size)), 0, 0, 360, _SKIN_BGR, -1)
        noisy = canvas + rng.normal(0, 2.0, canvas.shape)
        picture = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
        picture.flags.writeable = False
        pictures.append(picture)
    return StereoFrame(index, index * DT_S, tuple(pictures))


def _detector_faults(factory: Factory, limit_s: float) -> Iterator[str]:
    points = paths_m(3)
    wall = [painted(None, k, seed=1) for k in range(20)]
    first: list[tuple[Detections, ...]] = []
    second: list[tuple[Detections, ...]] = []
    expected = Estimates(
        points[0], np.tile(1e-4 * np.eye(3), (3, 1, 1)), np.zeros((3, 3)), ("tracked",) * 3
    )
    for found in (first, second):
        fresh = _built(factory, _DETECTOR_METHODS, limit_s)
        detector = _call("learn", limit_s, fresh.learn, wall)
        if not callable(detector):
            raise _Fault(f"learn: must return a detector, returns {type(detector).__name__}")
        for index, at in enumerate(points):
            for predicted in (None, expected):
                seen = _call("call", limit_s, detector, painted(at, index), predicted)
                yield from _detection_faults("call", seen)
                found.append(seen)
    for a, b in zip(first, second, strict=True):
        if not all(np.array_equal(x.centres_px, y.centres_px) for x, y in zip(a, b, strict=True)):
            yield "two detectors of the same factory: differ on the same pictures"
            break
    whole = painted(points[0], 0)
    lost = StereoFrame(0, 0.0, (None, whole.pictures[1]))
    seen = _call("call(left picture missing)", limit_s, detector, lost, None)
    yield from _detection_faults("call(left picture missing)", seen)
    if not seen[0].missing or len(seen[0]):
        yield "call(left picture missing): must give Detections.none(missing=True) for that view"
    if seen[1].missing:
        yield "call(left picture missing): the right one is there, but said to be missing"
    yield from _detection_faults(
        "call(empty scene)", _call("call(empty scene)", limit_s, detector, wall[0], None)
    )


def _detection_faults(what: str, seen: Any) -> Iterator[str]:
    cameras = cameras_in_front()
    _stop_at(what, fault_of_detections(seen, len(cameras)))
    for camera, view in zip(cameras, seen, strict=True):
        size = np.array([camera.width_px, camera.height_px])
        if ((view.centres_px < -0.5) | (view.centres_px > size - 0.5)).any():
            yield f"{what}: centres_px lie outside the picture (x, y in pixels)"
