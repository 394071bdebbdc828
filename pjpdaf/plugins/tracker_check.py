"""Conformance of a tracker: slow targets, then the hard frames of real footage."""

from __future__ import annotations

import pickle
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.follow import follow
from pjpdaf.interfaces import AnyTracker, Detections, Estimates, Smoother
from pjpdaf.known_targets import AssociationReplaceable, KnownTargets, PredictionReplaceable
from pjpdaf.plugins.answers import fault_of_estimates, fault_of_step
from pjpdaf.plugins.probe import CheckEnds, Probe
from pjpdaf.plugins.registry import Factory
from pjpdaf.plugins.scenes import DT_S, FRAMES, cameras_in_front, detections_of, paths_m
from pjpdaf.recorded import RecordedDetections
from pjpdaf.targets import TARGETS

METHODS = ("start", "step", "estimates", "predict")
SMOOTHED_FRAMES = 4
FAR_M = 0.3  # an estimate farther from its own target than this follows nothing


@dataclass
class ProbedTracker:
    """A `Tracker` whose every call goes through a probe, and every answer is checked."""

    tracker: AnyTracker
    probe: Probe
    started: bool = False

    def start(self, detections: tuple[Detections, ...]) -> Any:
        """Return the tracker's first state, or None."""
        state = self.probe.call("start", self.tracker.start, detections)
        self.started = state is not None
        return state

    def estimates(self, state: Any) -> Estimates:
        """Return the tracker's estimates."""
        return self._checked("estimates", self.tracker.estimates, state)

    def predict(self, state: Any, dt_s: float) -> Estimates:
        """Return the tracker's prediction."""
        return self._checked("predict", self.tracker.predict, state, dt_s)

    def step(
        self, state: Any, detections: tuple[Detections, ...], dt_s: float
    ) -> tuple[Any, Estimates]:
        """Return the tracker's state and estimates; the state that it was given must not change."""
        before = _frozen(state)
        answer = self.probe.call("step", self.tracker.step, state, detections, dt_s)
        self.probe.end_at("step", fault_of_step(answer))
        if before != _frozen(state):
            self.probe.add("step", "changes the state it was given; must return a new one")
        check_estimates(self.probe, "step", answer[1])
        after, estimates = answer
        return after, estimates

    def _checked(self, label: str, method: Any, *arguments: Any) -> Estimates:
        answer = self.probe.call(label, method, *arguments)
        check_estimates(self.probe, label, answer)
        estimates: Estimates = answer
        return estimates


def check(factory: Factory, probe: Probe) -> None:
    """Check a tracker. Raises CheckEnds."""
    tracker = probe.build(factory, METHODS)
    nothing = (Detections.none(),) * len(cameras_in_front())
    early = probe.call("start(no detections)", tracker.start, nothing)
    if early is not None:
        label = "estimates, started without detections"
        answer = probe.call(label, tracker.estimates, early)
        check_estimates(probe, label, answer, {"waiting", "lost"})
    first = _follow_slow_targets(tracker, probe)
    again = probe.build(factory, METHODS)
    try:
        second = _follow_slow_targets(again, probe)
    except CheckEnds:
        probe.add("a second tracker of the same factory", "fails where the first did not")
        return
    if not all(_equal(a, b) for a, b in zip(first, second, strict=True)):
        probe.add(
            "two trackers of the same factory",
            "differ on the same detections; must be repeatable",
        )
    _check_smoothing(tracker, probe)
    _check_hard_frames(tracker, probe)


def _follow_slow_targets(tracker: AnyTracker, probe: Probe) -> list[Estimates]:
    """Estimates of all frames of three slow targets, their blobs in random order."""
    cameras, paths = cameras_in_front(), paths_m()
    rng = np.random.default_rng(0)
    recorded = RecordedDetections(
        tuple(
            detections_of(cameras, points, rng.permutation(len(TARGETS)).tolist())
            for points in paths
        )
    )
    frames = recorded.frames(DT_S * np.arange(len(paths)))
    estimates = []
    probed = ProbedTracker(tracker, probe)
    for step in follow(frames, recorded, probed):
        estimates.append(step.estimates)
        probe.faults += order_faults(step.estimates, paths[step.frame.index])
    if not probed.started:
        raise CheckEnds(f"start: no state in {FRAMES} frames of three clear blobs in both views")
    probe.faults += _distance_faults(estimates[-1], paths[-1])
    return estimates


def order_faults(estimates: Estimates, truth_m: Floats) -> list[str]:
    """Rows that are near another target than their own, where each target has its row."""
    between = np.linalg.norm(estimates.positions_m[:, None] - truth_m[None], axis=-1)
    if not np.isfinite(between).all() or between.min(axis=1).max() > FAR_M:
        return []
    nearest = between.argmin(axis=1).tolist()
    if sorted(nearest) != [0, 1, 2]:
        return []
    return [
        f"wrong order of targets: row {row} must be the {TARGETS[row]}, follows the "
        f"{TARGETS[target]}; the order is {', '.join(TARGETS)}"
        for row, target in enumerate(nearest)
        if row != target
    ]


def _distance_faults(estimates: Estimates, truth_m: Floats) -> list[str]:
    """The row farthest from its own target, if far; not where only their order is wrong."""
    between = np.linalg.norm(estimates.positions_m - truth_m, axis=-1)
    if not between.max() > FAR_M or order_faults(estimates, truth_m):
        return []
    row = int(between.argmax())
    return [
        f"{TARGETS[row]}: is {between[row]:.2f} m off after {FRAMES} frames of three "
        f"clear blobs in both views (positions are in the world, in metres)"
    ]


def check_estimates(
    probe: Probe, label: str, answer: Any, unplaced: Collection[str] = ("waiting",)
) -> None:
    """Check shapes, finite numbers, covariances; unplaced: statuses whose numbers may be NaN."""
    probe.end_at(label, fault_of_estimates(answer))
    placed = np.array([status not in unplaced for status in answer.status])
    for name in ("positions_m", "covariances_m2", "velocities_mps"):
        if not np.isfinite(getattr(answer, name)[placed]).all():
            probe.add(label, f"{name} has NaN values")
    for P in answer.covariances_m2[placed]:
        if np.isfinite(P).all():
            scale = max(1e-12, float(np.abs(P).max()))
            if np.abs(P - P.T).max() > 1e-6 * scale:
                probe.add(label, "covariances_m2 are not symmetric")
            elif np.linalg.eigvalsh(P)[0] < -1e-6 * scale:
                probe.add(label, "covariances_m2 have negative eigenvalues")


def _check_smoothing(tracker: AnyTracker, probe: Probe) -> None:
    """Estimates of an earlier frame, of a tracker that gives them."""
    if not isinstance(tracker, Smoother):
        return
    cameras, paths = cameras_in_front(), paths_m()
    states: list[Any] = []
    for points in paths[:SMOOTHED_FRAMES]:
        seen = detections_of(cameras, points, range(3))
        if states:
            states.append(probe.call("step", tracker.step, states[-1], seen, DT_S)[0])
        elif (state := probe.call("start", tracker.start, seen)) is not None:
            states.append(state)
    for past in (states[:1], states) if states else ():
        label = "smoothed(one state)" if len(past) == 1 else "smoothed"
        answer = probe.call(label, tracker.smoothed, tuple(past))
        check_estimates(probe, label, answer)
        if len(past) == 1 and not _equal(answer, tracker.estimates(past[0])):
            probe.add(label, "differs from the estimates of this state")


def _check_hard_frames(tracker: AnyTracker, probe: Probe) -> None:
    """Frames of real footage: no blobs, a missing picture, one blob, uneven time steps."""
    cameras, paths = cameras_in_front(), paths_m()
    whole = detections_of(cameras, paths[0], range(3))
    state = probe.call("start", tracker.start, whole)
    if state is None:  # a tracker that waits for more frames; it was checked above
        return
    none, missing = Detections.none(), Detections.none(missing=True)
    frames = {
        "no detections": (none, none),
        "a missing picture": (missing, whole[1]),
        "both pictures missing": (missing, missing),
        "one blob": detections_of(cameras, paths[0], [1]),
        "one view empty": (whole[0], none),
    }
    for name, detections in frames.items():
        for dt_s in (1 / 30, 1.0):
            label = f"step({name}, dt {dt_s:.2g} s)"
            answer = probe.call(label, tracker.step, state, detections, dt_s)
            probe.end_at(label, fault_of_step(answer))
            check_estimates(probe, label, answer[1], {"waiting", "lost"})
            state = answer[0]
    _check_replaceable(tracker, probe)


def _check_replaceable(tracker: AnyTracker, probe: Probe) -> None:
    """The methods that replace a stage, where the tracker has them: of slow targets, all shown."""
    cameras, paths = cameras_in_front(), paths_m()
    first, after = (detections_of(cameras, points, range(3)) for points in paths[:2])
    state = probe.call("start", tracker.start, first)
    if state is None:
        return
    velocities = (paths[1] - paths[0]) / DT_S
    shown_by = np.tile(np.arange(len(TARGETS)), (len(cameras), 1))
    known = KnownTargets(paths[1], velocities, shown_by)
    if isinstance(tracker, AssociationReplaceable):
        label = "step_associated"
        answer = probe.call(label, tracker.step_associated, state, after, known, DT_S)
        probe.end_at(label, fault_of_step(answer))
        check_estimates(probe, label, answer[1])
    if isinstance(tracker, PredictionReplaceable):
        moved = probe.call("expecting", tracker.expecting, state, known, DT_S)
        answer = probe.call("step after expecting", tracker.step, moved, after, DT_S)
        probe.end_at("step after expecting", fault_of_step(answer))
        check_estimates(probe, "step after expecting", answer[1])


def _frozen(state: Any) -> bytes | str:
    """Bytes of a state to compare with, its text where it cannot be pickled."""
    try:
        return pickle.dumps(state)
    except Exception:
        return repr(getattr(state, "__dict__", state))


def _equal(a: Estimates, b: Estimates) -> bool:
    names = ("positions_m", "covariances_m2", "velocities_mps", "exchange_probability")
    same = all(np.array_equal(getattr(a, n), getattr(b, n), equal_nan=True) for n in names)
    return same and a.status == b.status
