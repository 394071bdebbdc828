"""Each fault of a plug-in is a line; a plug-in without faults passes."""

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.conformance import check_detector, check_named, check_tracker
from pjpdaf.plugins.loading import PlugInError
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.plugins.scenes import cameras_in_front, detections_of, painted, paths_m
from pjpdaf.tracker.filter import PJPDAF
from pjpdaf.tracker.state import TrackState

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module", autouse=True)
def _painted_once():
    """Each picture of the wall is painted once for all tests: to paint it takes most of a check."""
    pictures = {}

    def remembered(points_m, index, seed=0):
        key = (None if points_m is None else points_m.tobytes(), index, seed)
        if key not in pictures:
            pictures[key] = painted(points_m, index, seed)
        return pictures[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pjpdaf.plugins.detector_check.painted", remembered)
        yield


class Tracker:
    """Right in everything; the faulty ones change one thing."""

    def __init__(self, cameras):
        self.inner = PJPDAF(cameras)

    def start(self, seen):
        return self.inner.start(seen)

    def step(self, state, seen, dt_s):
        return self.inner.step(state, seen, dt_s)

    def estimates(self, state):
        return self.inner.estimates(state)

    def predict(self, state, dt_s):
        return self.inner.predict(state, dt_s)


def changed(estimates, **values):
    return replace(estimates, **values)


class Raises(Tracker):
    def step(self, state, seen, dt_s):
        raise KeyError("nothing\nhere")


class Hangs(Tracker):
    def step(self, state, seen, dt_s):
        time.sleep(3)


class NeverStarts(Tracker):
    def start(self, seen):
        return None


class StateAlone(Tracker):
    def step(self, state, seen, dt_s):
        return super().step(state, seen, dt_s)[0]


class Positions(Tracker):
    def estimates(self, state):
        return super().estimates(state).positions_m


class TwoTargets(Tracker):
    def estimates(self, state):
        estimates = super().estimates(state)
        return Estimates(
            estimates.positions_m[:2],
            estimates.covariances_m2[:2],
            estimates.velocities_mps[:2],
            estimates.status[:2],
        )


class WrongShape(Tracker):
    def estimates(self, state):
        estimates = super().estimates(state)
        return changed(estimates, velocities_mps=estimates.velocities_mps[:, :2])


class Nan(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        return after, changed(estimates, positions_m=estimates.positions_m * np.nan)


class Swapped(Tracker):
    def estimates(self, state):
        estimates = super().estimates(state)
        return changed(estimates, positions_m=estimates.positions_m[[0, 2, 1]])

    def step(self, state, seen, dt_s):
        after = super().step(state, seen, dt_s)[0]
        return after, self.estimates(after)


class Millimetres(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        return after, changed(estimates, positions_m=1000 * estimates.positions_m)


class Lopsided(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        return after, changed(estimates, covariances_m2=-estimates.covariances_m2)


class Mutates(Tracker):
    def start(self, seen):
        state = super().start(seen)
        return None if state is None else {"now": state}

    def estimates(self, state):
        return super().estimates(state["now"])

    def predict(self, state, dt_s):
        return super().predict(state["now"], dt_s)

    def step(self, state, seen, dt_s):
        state["now"], estimates = super().step(state["now"], seen, dt_s)
        return state, estimates


class Random(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        mean = after.mean + np.random.default_rng().normal(0, 1e-4, after.mean.shape)
        return TrackState(mean, after.covariance, after.unseen_s, after.status), estimates


class BlindToGaps(Tracker):
    def step(self, state, seen, dt_s):
        assert all(len(view) for view in seen), "no blobs"
        return super().step(state, seen, dt_s)


class Infinite(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        return after, changed(estimates, velocities_mps=np.full((3, 3), np.inf))


class Diverges(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        return after, changed(estimates, positions_m=1e300 * estimates.positions_m)


class ForgetsItsState(Tracker):
    def step(self, state, seen, dt_s):
        return None, super().step(state, seen, dt_s)[1]


class SwappedAtFirst(Tracker):
    """Right in the last frame."""

    def estimates(self, state):
        estimates = super().estimates(state)
        return changed(estimates, positions_m=estimates.positions_m[::-1])


class Unspeakable(Exception):
    def __str__(self):
        raise ValueError


class RaisesUnspeakable(Tracker):
    def step(self, state, seen, dt_s):
        raise Unspeakable


class StartsOddly(Tracker):
    """Its state without detections is none that it can read."""

    def start(self, seen):
        return super().start(seen) if len(seen[0]) else 42


class LooksBackWrongly(Tracker):
    """Of one state alone it gives other estimates than those of the state."""

    def smoothed(self, states):
        estimates = self.estimates(states[0])
        return changed(estimates, positions_m=estimates.positions_m + 0.01)


class TooSure(Tracker):
    def step(self, state, seen, dt_s):
        after, estimates = super().step(state, seen, dt_s)
        return after, changed(estimates, exchange_probability=1.5)


class AssociatesAlone(Tracker):
    def step_associated(self, state, seen, known, dt_s):
        return self.inner.step_associated(state, seen, known, dt_s)[1]


class ExpectsNothing(Tracker):
    def expecting(self, state, known, dt_s):
        return None


class NoPredict:
    start = step = estimates = print


@pytest.mark.parametrize(
    ("factory", "line"),
    [
        (lambda cameras: 1 / 0, "factory(cameras): raises ZeroDivisionError: division by zero"),
        (lambda cameras: NoPredict(), "lacks predict"),
        (Raises, r"step: raises KeyError: 'nothing\nhere' (test_conformance.py:"),
        (Hangs, "step: has not returned after 1 s"),
        (NeverStarts, "start: no state in 12 frames"),
        (StateAlone, "step: must return (state, Estimates)"),
        (Positions, "estimates: must give an Estimates, gives ndarray"),
        (TwoTargets, "estimates: must have 3 targets (head, right_hand, left_hand), has 2"),
        (WrongShape, "estimates: raises ValueError: Estimates.velocities_mps"),
        (Nan, "step: positions_m has NaN values"),
        (Swapped, "wrong order of targets: row 1 must be the right_hand, follows the left_hand"),
        (Millimetres, "m off after 12 frames"),
        (Lopsided, "step: covariances_m2 have negative eigenvalues"),
        (Mutates, "step: changes the state it was given; must return a new one"),
        (Infinite, "step: velocities_mps has infinite values"),
        (Diverges, "step: positions_m has a value of 1.2e+300 m"),
        (ForgetsItsState, "step: must return a state, returns None"),
        (SwappedAtFirst, "wrong order of targets: row 0 must be the head, follows the left_hand"),
        (RaisesUnspeakable, "step: raises Unspeakable (test_conformance.py:"),
        (StartsOddly, "estimates, started without detections: raises AttributeError"),
        (LooksBackWrongly, "smoothed(one state): differs from the estimates of this state"),
        (TooSure, "step: raises ValueError: Estimates.exchange_probability must be from 0 to 1"),
        (Random, "two trackers of the same factory: differ"),
        (AssociatesAlone, "step_associated: must return (state, Estimates)"),
        (ExpectsNothing, "step after expecting: raises AttributeError"),
        (BlindToGaps, "step(no detections, dt 0.033 s): raises AssertionError: no blobs"),
    ],
)
def test_what_is_wrong_with_a_tracker_is_one_line(factory, line):
    lines = check_tracker(factory, limit_s=1.0)
    assert any(line in fault for fault in lines), lines
    assert all("\n" not in fault for fault in lines)


@pytest.mark.parametrize("name", ["thesis", "thesis-literal"])
def test_the_shipped_trackers_and_detectors_conform(name):
    assert check_named("tracker", name) == ()
    assert check_named("detector", name) == ()


def test_the_example_conforms_in_under_forty_lines(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    assert check_named("tracker", "own_tracker:NearestBlob") == ()
    assert len((EXAMPLES / "own_tracker.py").read_text().splitlines()) < 40


def test_the_example_follows_the_targets(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    from own_tracker import NearestBlob

    cameras, paths = cameras_in_front(), paths_m(30)
    tracker = NearestBlob(cameras)
    state = tracker.start(detections_of(cameras, paths[0], range(3)))
    for points in paths[1:]:
        state, estimates = tracker.step(state, detections_of(cameras, points, [2, 0, 1]), 1 / 3)
        assert np.abs(estimates.positions_m - points).max() < 1e-6
    none = (Detections.none(), Detections.none())
    assert tracker.step(state, none, 1 / 3)[1].status == ("coasting",) * 3
    sys.modules.pop("own_tracker")


class Detector:
    def __init__(self, cameras, background=None):
        self.cameras = cameras
        self.inner = make_detector("thesis", cameras) if background is None else background

    def learn(self, background):
        return type(self)(self.cameras, self.inner.learn(background))

    def __call__(self, frame, predicted=None):
        return self.inner(frame, predicted)


class OneView(Detector):
    def __call__(self, frame, predicted=None):
        return super().__call__(frame, predicted)[:1]


class AsList(Detector):
    def __call__(self, frame, predicted=None):
        return list(super().__call__(frame, predicted))


class Forgets(Detector):
    def learn(self, background):
        return None


class Paints(Detector):
    def __call__(self, frame, predicted=None):
        frame.pictures[1][:] = 0
        return super().__call__(frame, predicted)


class Unannounced(Detector):
    def __call__(self, frame, predicted=None):
        if frame.pictures[0] is None:
            return (Detections.none(), super().__call__(frame, predicted)[1])
        return super().__call__(frame, predicted)


class Outside(Detector):
    def __call__(self, frame, predicted=None):
        return tuple(
            Detections(d.centres_px + 700, d.covariances_px2, d.ellipses, d.areas_px, d.missing)
            for d in super().__call__(frame, predicted)
        )


@pytest.mark.parametrize(
    ("factory", "line"),
    [
        (OneView, "call: must give 2 views, gives 1"),
        (AsList, "call: must give a tuple of Detections"),
        (Forgets, "learn: must return a detector, returns NoneType"),
        (Paints, "call: raises ValueError: assignment destination is read-only"),
        (Unannounced, "call(left picture missing): must give Detections.none(missing=True)"),
        (Outside, "call: centres_px lie outside the picture"),
    ],
)
def test_what_is_wrong_with_a_detector_is_one_line(factory, line):
    lines = check_detector(factory)
    assert any(line in fault for fault in lines), lines


def test_the_painted_scene_shows_three_blobs_in_each_view():
    detector = make_detector("thesis", cameras_in_front()).learn(
        [painted(None, k) for k in range(20)]
    )
    assert [len(view) for view in detector(painted(paths_m(1)[0], 0))] == [3, 3]


def test_a_name_that_is_not_there_and_a_kind_that_is_not():
    """The name is at fault, not the plug-in: exit code 2."""
    with pytest.raises(BenchError, match="'nowhere:make' cannot be imported: No module named"):
        check_named("tracker", "nowhere:make")
    with pytest.raises(BenchError, match=r"No 'make' in 'pjpdaf\.tracker\.filter'"):
        check_named("tracker", "pjpdaf.tracker.filter:make")
    with pytest.raises(BenchError, match=r"No tracker 'thesiss'\. Did you mean 'thesis'"):
        check_named("tracker", "thesiss")
    with pytest.raises(BenchError, match="--kind must be tracker, detector or motion, got 'x'"):
        check_named("x", "thesis")
    for limit_s in (0.0, -1.0, float("nan")):
        with pytest.raises(BenchError, match="--limit must be above 0"):
            check_named("tracker", "thesis", limit_s)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("raise RuntimeError('of\\nmine')", "cannot be imported: RuntimeError: of mine (odd_plug"),
        ("import sys; sys.exit(3)", "cannot be imported: SystemExit: 3 (odd_plug"),
        ("def make(cameras): return {}[0]", "cannot be built: KeyError: 0 (odd_plug"),
        ("import no_such_library", "cannot be imported: No module named 'no_such_library'"),
    ],
)
def test_a_plug_in_that_cannot_be_made_is_one_line(text, line, tmp_path, monkeypatch):
    (tmp_path / "odd_plug.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "odd_plug", raising=False)
    with pytest.raises(PlugInError) as fault:
        make_tracker("odd_plug:make", cameras_in_front())
    assert line in str(fault.value)
    assert "\n" not in str(fault.value)
    assert line in check_named("tracker", "odd_plug:make")[0]
