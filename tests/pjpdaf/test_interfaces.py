"""Records between detector and tracker: checked at the door, read-only, picklable."""

import pickle

import numpy as np
import pytest
from strategies import START_W, PointWorld, rig

from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.conformance import check_detector
from pjpdaf.plugins.registry import make_detector, make_tracker

CAMERAS = rig().cameras
EVIDENCE = np.array([[-0.1, -3.0, -np.inf], [-2.0, 0.4, -1.0]])


def two_blobs(**fields):
    n = 2
    return Detections(
        np.zeros((n, 2)), np.tile(np.eye(2), (n, 1, 1)), np.zeros((n, 5)), np.ones(n), **fields
    )


def test_evidence_is_optional_read_only_and_survives_pickling():
    assert two_blobs().evidence is None
    assert Detections.none().evidence is None
    given = EVIDENCE.copy()
    view = two_blobs(evidence=given)
    given[:] = 0.0
    for record in (view, pickle.loads(pickle.dumps(view))):
        np.testing.assert_array_equal(record.evidence, EVIDENCE)
    with pytest.raises(ValueError, match="read-only"):
        view.evidence[0, 0] = 1.0


@pytest.mark.parametrize(
    ("evidence", "rule"),
    [
        (np.zeros((3, 3)), r"Detections.evidence must have shape \(2, n\), got \(3, 3\)"),
        (np.zeros(2), r"Detections.evidence must have shape \(2, n\), got \(2,\)"),
        (np.full((2, 3), np.nan), "Detections.evidence must be finite or -inf, got NaN or"),
        (np.full((2, 3), np.inf), "Detections.evidence must be finite or -inf, got NaN or"),
    ],
)
def test_wrong_evidence_is_refused(evidence, rule):
    with pytest.raises(ValueError, match=rule):
        two_blobs(evidence=evidence)


def with_evidence(view, columns=3):
    rows = np.full((len(view), columns), -1.5)
    return Detections(
        view.centres_px,
        view.covariances_px2,
        view.ellipses,
        view.areas_px,
        view.missing,
        evidence=rows,
    )


def test_the_trackers_do_not_use_it_yet():
    tracker = make_tracker("thesis", CAMERAS)
    seen = PointWorld(1.0, 0.0, 1.0).see(CAMERAS, START_W, np.random.default_rng(3))
    state = tracker.start_at(START_W)
    plain = tracker.step(state, seen, 1 / 3)[1]
    informed = tracker.step(state, tuple(map(with_evidence, seen)), 1 / 3)[1]
    np.testing.assert_array_equal(informed.positions_m, plain.positions_m)


class Witness:
    """The thesis's detector, with evidence for each blob."""

    def __init__(self, inner, columns):
        self.inner, self.columns = inner, columns

    def learn(self, background):
        return Witness(self.inner.learn(background), self.columns)

    def __call__(self, frame, predicted=None):
        return tuple(with_evidence(view, self.columns) for view in self.inner(frame, predicted))


@pytest.mark.long
def test_a_detector_that_gives_evidence_conforms():
    assert check_detector(lambda cameras: Witness(make_detector("thesis", cameras), 3)) == ()
    (fault,) = check_detector(lambda cameras: Witness(make_detector("thesis", cameras), 2))
    assert fault == (
        "call: evidence must have a column for each of 3 targets (head, right_hand, left_hand), "
        "has 2"
    )


@pytest.mark.parametrize("stated", [-0.01, 1.01, np.inf, "0.5", None])
def test_an_exchange_probability_is_from_0_to_1_or_nan(stated):
    assert np.isnan(Estimates.waiting().exchange_probability)
    row = np.zeros((3, 3)), np.zeros((3, 3, 3)), np.zeros((3, 3)), ("tracked",) * 3
    assert Estimates(*row, np.float32(0.25)).exchange_probability == 0.25
    with pytest.raises(ValueError, match="exchange_probability must be from 0 to 1, or NaN"):
        Estimates(*row, stated)


def test_estimates_are_checked_at_the_door():
    assert Estimates.waiting().status == ("waiting",) * 3
    assert np.isnan(Estimates.waiting().positions_m).all()
    with pytest.raises(ValueError, match=r"Estimates.positions_m must have shape \(1, 3\)"):
        Estimates(np.zeros((2, 3)), np.zeros((1, 3, 3)), np.zeros((1, 3)), ("tracked",))
    with pytest.raises(ValueError, match=r"Estimates.status must be one of .* got \['gone'\]"):
        Estimates(np.zeros((1, 3)), np.zeros((1, 3, 3)), np.zeros((1, 3)), ("gone",))
