"""The loop: order of the calls, what passes between detector and tracker, faults, laziness."""

from dataclasses import dataclass

import numpy as np
import pytest
from strategies import PointWorld, rig

from pjpdaf.errors import BenchError, PlugInFault
from pjpdaf.follow import follow
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.registry import make_tracker

CAMERAS = rig().cameras
TARGETS_M = np.array([[0.0, 0.0, 1.2], [0.3, -0.2, 0.85], [0.3, 0.2, 0.85]])
TIMES_S = (0.0, 0.5, 0.75, 1.75, 2.0)


def frames(times_s=TIMES_S, first=0):
    for number, time_s in enumerate(times_s, start=first):
        yield StereoFrame(number, time_s, (None, None))


@dataclass
class Points:
    """A detector that sees the targets' exact centres from frame `first` on, and keeps a record."""

    first: int = 0

    def __post_init__(self):
        self.expected = []

    def learn(self, background):
        return self

    def __call__(self, frame, predicted=None):
        self.expected.append(predicted)
        if frame.index < self.first:
            return (Detections.none(),) * 2
        world = PointWorld(noise_px=0.3, miss=0, clutter=0)
        return world.see(CAMERAS, TARGETS_M, np.random.default_rng(frame.index))


def by_hand(detector, tracker, frames):
    """The protocol of docs/own_tracker.md, called in order."""
    state, last_s = None, None
    for frame in frames:
        expected = None if state is None else tracker.predict(state, frame.time_s - last_s)
        detections = detector(frame, expected)
        if state is not None:
            state, estimates = tracker.step(state, detections, frame.time_s - last_s)
        else:
            state = tracker.start(detections)
            estimates = tracker.estimates(state) if state else Estimates.waiting()
        last_s = frame.time_s
        yield estimates


def test_the_loop_gives_what_the_protocol_gives_called_by_hand():
    tracker = make_tracker("thesis", CAMERAS, {})
    steps = list(follow(frames(), Points(first=2), tracker))
    reference = list(by_hand(Points(first=2), tracker, frames()))
    for step, estimates in zip(steps, reference, strict=True):
        np.testing.assert_array_equal(step.estimates.positions_m, estimates.positions_m)
        np.testing.assert_array_equal(step.estimates.covariances_m2, estimates.covariances_m2)
        assert step.estimates.status == estimates.status
    assert [step.estimates.status[0] for step in steps[:3]] == ["waiting", "waiting", "tracked"]


def test_times_are_those_between_frames_and_the_detector_is_given_the_prediction():
    detector, tracker = Points(first=1), make_tracker("thesis", CAMERAS, {})
    steps = list(follow(frames(), detector, tracker))
    assert [step.dt_s for step in steps] == [0.0, 0.5, 0.25, 1.0, 0.25]
    assert [step.frame.index for step in steps] == [0, 1, 2, 3, 4]
    # None in frame 0, and in frame 1, where the tracker starts only after the detector.
    assert [expected is None for expected in detector.expected] == [True, True, False, False, False]
    before, expected = steps[2].estimates, detector.expected[3]
    ahead = before.positions_m + steps[3].dt_s * before.velocities_mps
    np.testing.assert_allclose(expected.positions_m, ahead, atol=1e-12)
    assert all(min(step.render_s, step.detect_s, step.track_s) >= 0 for step in steps)


def test_a_frame_is_taken_only_when_its_turn_comes():
    taken = []

    def counted():
        for frame in frames():
            taken.append(frame.index)
            yield frame

    steps = follow(counted(), Points(), make_tracker("thesis", CAMERAS, {}))
    assert taken == []
    next(steps)
    next(steps)
    assert taken == [0, 1]


class Faulty(Points):
    def __call__(self, frame, predicted=None):
        if frame.index == 9:
            raise PlugInFault("detector 'own': call: raises ValueError")
        return super().__call__(frame, predicted)


def test_a_plug_ins_fault_names_the_frame():
    steps = follow(frames(first=7), Faulty(), make_tracker("thesis", CAMERAS, {}))
    assert next(steps).frame.index == 7
    assert next(steps).frame.index == 8
    with pytest.raises(PlugInFault, match=r"^frame 9: detector 'own': call: raises ValueError$"):
        next(steps)


def test_other_faults_come_out_as_they_are_after_the_frames_before_them():
    def damaged():
        yield from frames(TIMES_S[:2])
        raise BenchError("left/2.png: the picture is 3x2 px")

    steps = follow(damaged(), Points(), make_tracker("thesis", CAMERAS, {}))
    assert len([next(steps), next(steps)]) == 2
    with pytest.raises(BenchError, match=r"^left/2.png: the picture is 3x2 px$"):
        next(steps)


class Counter:
    """A smoother whose state is the number of frames since it began."""

    def start(self, seen):
        return 0 if len(seen[0]) else None

    def step(self, state, seen, dt_s):
        return state + 1, self.estimates(state + 1)

    def estimates(self, state):
        return self.smoothed((state,))

    def predict(self, state, dt_s):
        return self.estimates(state)

    def smoothed(self, states):
        """Position: first state, last state, how many."""
        place = np.tile([float(states[0]), float(states[-1]), float(len(states))], (3, 1))
        return Estimates(place, np.zeros((3, 3, 3)), np.zeros((3, 3)), ("tracked",) * 3)


def test_with_a_lag_a_frame_comes_later_and_knows_the_frames_between():
    taken = []

    def counted():
        for frame in frames():
            taken.append(frame.index)
            yield frame

    steps = follow(counted(), Points(first=1), Counter(), lag=2)
    first = next(steps)
    assert (first.frame.index, taken) == (0, [0, 1, 2])
    assert first.estimates.status[0] == "waiting"
    rest = list(steps)
    assert [step.frame.index for step in rest] == [1, 2, 3, 4]
    known = [step.estimates.positions_m[0].tolist() for step in rest]
    assert known == [[0, 2, 3], [1, 3, 3], [2, 3, 2], [3, 3, 1]]
    plain = list(follow(frames(), Points(first=1), Counter()))
    assert [step.dt_s for step in plain] == [step.dt_s for step in [first, *rest]]


def test_frames_held_for_a_lag_come_out_before_a_fault():
    def damaged():
        yield from frames(TIMES_S[:3])
        raise BenchError("left/3.png: the picture is 3x2 px")

    steps = follow(damaged(), Points(), Counter(), lag=2)
    assert [next(steps).frame.index for _ in range(3)] == [0, 1, 2]
    with pytest.raises(BenchError, match="the picture is 3x2 px"):
        next(steps)


def test_a_lag_needs_a_tracker_that_looks_back():
    with pytest.raises(ValueError, match="needs a tracker that is a Smoother"):
        next(follow(frames(), Points(), make_tracker("thesis", CAMERAS, {}), lag=1))
