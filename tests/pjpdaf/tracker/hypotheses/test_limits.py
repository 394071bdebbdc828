"""Limits of the hypothesis tracker: bounded cost, strangers' hands, long absence, frame rates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import Camera, StereoRig, project
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.looks import looks_of_ellipses
from pjpdaf.tracker.hypotheses import tracker as module
from pjpdaf.tracker.hypotheses.blobs import MOST_BLOBS, Blobs
from pjpdaf.tracker.hypotheses.costs import MOST_PAIRS
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters, OffsetParameters
from pjpdaf.tracker.hypotheses.tracker import HypothesisState, HypothesisTracker
from tests.strategies import detections, rig

PARALLEL = rig().cameras
START_W = np.array([[0.0, 0.0, 1.2], [0.1, -0.2, 0.8], [0.1, 0.2, 0.8]])
AREAS = np.array([4500.0, 1500, 1500])
NO_OFFSET = (0.0, 0.0, 0.0)
PLAIN = HypothesisParameters(offsets=OffsetParameters(NO_OFFSET, NO_OFFSET, outward_m=0.0))
FRAME_S = 1 / 3
NAMES = {"head": 0, "right": 1, "left": 2}


def converging() -> tuple[Camera, ...]:
    """The same cameras, turned so that their axes meet before the person."""
    turned = []
    for camera, angle in zip(PARALLEL, (-0.1, 0.1), strict=True):
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ camera.R_cw
        turned.append(replace(camera, R_cw=R, t_cw=-R @ camera.centre_w))
    return StereoRig(*turned).cameras


RIGS = pytest.mark.parametrize("cameras", [PARALLEL, converging()], ids=["parallel", "converging"])


def seen(
    cameras: tuple[Camera, ...], points: np.ndarray, areas: np.ndarray
) -> tuple[Detections, ...]:
    return tuple(detections(project(camera, points), areas) for camera in cameras)


def started(cameras: tuple[Camera, ...]) -> tuple[HypothesisTracker, HypothesisState]:
    one = HypothesisTracker(cameras, PLAIN)
    state = one.start(seen(cameras, START_W, AREAS))
    assert state is not None
    return one, state


def kept(
    one: HypothesisTracker,
    state: HypothesisState,
    points: np.ndarray,
    areas: np.ndarray,
    frames: int,
    dt_s: float = FRAME_S,
) -> tuple[HypothesisState, Estimates]:
    """The same detections for some frames."""
    for _ in range(frames):
        state, estimates = one.step(state, seen(one.cameras, points, areas), dt_s)
    return state, estimates


def test_the_work_of_a_frame_is_bounded_however_many_blobs_there_are(monkeypatch):
    counts = []

    def counted(hypotheses, sightings, *rest):
        counts.append((len(hypotheses), len(sightings.pairs)))
        return grow(hypotheses, sightings, *rest)

    grow = module.grow
    monkeypatch.setattr(module, "grow", counted)
    rng = np.random.default_rng(0)
    one, state = started(PARALLEL)
    for blobs in (10, 30, 300):
        clutter = rng.uniform([-0.2, -0.5, 0.7], [0.5, 0.5, 0.9], (blobs, 3))
        points = np.concatenate([START_W, clutter])
        areas = np.concatenate([AREAS, rng.uniform(400, 1400, blobs)])
        state, _ = kept(one, state, points, areas, 1)
    hypotheses, pairs = np.array(counts).T
    assert max(hypotheses) <= PLAIN.hypotheses
    assert pairs[0] < pairs[1] <= pairs[2] == MOST_PAIRS


def test_of_too_many_blobs_the_largest_are_kept_with_their_looks():
    rng = np.random.default_rng(1)
    areas = rng.permutation(np.arange(100.0, 100.0 + 2 * MOST_BLOBS))
    view = detections(rng.uniform(0, 400, (2 * MOST_BLOBS, 2)), areas)
    view = replace(view, looks=looks_of_ellipses(view.ellipses), evidence=np.zeros((len(view), 3)))
    blobs = Blobs.of(view)
    assert len(blobs) == len(blobs.looks.pixels) == len(blobs.looks.palms) == MOST_BLOBS
    assert blobs.evidence is not None
    assert len(blobs.evidence) == MOST_BLOBS
    assert blobs.areas_px.min() > np.median(areas)
    for centre, pixels in zip(blobs.centres_px, blobs.looks.pixels, strict=True):
        np.testing.assert_allclose(pixels.mean(axis=0), centre, atol=0.1)


@RIGS
@pytest.mark.parametrize("beside_m", [0.12, 0.2, 0.3])
def test_a_strangers_hand_that_passes_takes_no_name(cameras, beside_m):
    """It comes from the side of the picture, stops beside the left hand and goes again."""
    one, state = started(cameras)
    for y in [0.6, 0.45, *[0.2 + beside_m] * 4, 0.45, 0.6]:
        points = np.concatenate([START_W, [[0.1, y, 0.8]]])
        state, estimates = kept(one, state, points, np.append(AREAS, 1500.0), 1)
        np.testing.assert_allclose(estimates.positions_m, START_W, atol=0.02)
        assert estimates.status == ("tracked",) * 3


def test_many_strangers_hands_take_no_name():
    """Pairs of one thing's left blob and another's right must not look like an explanation."""
    rng = np.random.default_rng(0)
    one, state = started(PARALLEL)
    clutter = rng.uniform([-0.2, -0.5, 0.5], [0.5, 0.5, 1.3], (20, 3))
    clutter = clutter[np.linalg.norm(clutter[:, None] - START_W, axis=2).min(axis=1) > 0.15]
    points = np.concatenate([START_W, clutter])
    areas = np.concatenate([AREAS, np.full(len(clutter), 1500.0)])
    _, estimates = kept(one, state, points, areas, 4)
    np.testing.assert_allclose(estimates.positions_m, START_W, atol=0.05)


@RIGS
@pytest.mark.parametrize("absent", list(NAMES))
@pytest.mark.parametrize("seconds", [2.0, 20.0])
def test_after_an_absence_a_target_comes_back_under_its_own_name(cameras, absent, seconds):
    one, state = started(cameras)
    gone = NAMES[absent]
    rest = np.delete(np.arange(3), gone)
    state, estimates = kept(one, state, START_W[rest], AREAS[rest], round(seconds / FRAME_S))
    assert estimates.status[gone] == "lost"
    np.testing.assert_allclose(estimates.positions_m[rest], START_W[rest], atol=0.02)
    back = START_W.copy()
    if absent != "head":  # a hand comes back anywhere, the head where heads are
        back[gone] = (0.3, -0.45 if absent == "right" else 0.45, 1.0)
    _, estimates = kept(one, state, back, AREAS, 3)
    assert estimates.status == ("tracked",) * 3
    np.testing.assert_allclose(estimates.positions_m, back, atol=0.03)


@RIGS
@pytest.mark.parametrize("crossed", [False, True])
def test_after_a_long_absence_of_all_the_evidence_of_sides_names_them(cameras, crossed):
    one, state = started(cameras)
    state, estimates = kept(one, state, START_W[:0], AREAS[:0], 60)
    assert estimates.status == ("lost",) * 3
    back = START_W + np.array([[0.05, 0.0, 0.0], [0.1, -0.1, 0.1], [0.1, 0.1, 0.05]])
    back = back[[0, 2, 1]] if crossed else back
    sides = np.array([[0.0, 0, 0], [0, 0, -6], [0, -6, 0]])
    views = tuple(replace(view, evidence=sides) for view in seen(cameras, back, AREAS))
    for _ in range(3):
        state, estimates = one.step(state, views, FRAME_S)
    assert estimates.status == ("tracked",) * 3
    np.testing.assert_allclose(estimates.positions_m, back, atol=0.03)


@RIGS
def test_after_a_long_absence_of_all_without_evidence_the_doubt_is_stated(cameras):
    one, state = started(cameras)
    state, _ = kept(one, state, START_W[:0], AREAS[:0], 60)
    back = START_W + np.array([[0.05, 0.0, 0.0], [0.1, -0.1, 0.1], [0.1, 0.1, 0.05]])
    state, estimates = kept(one, state, back, AREAS, 3)
    assert estimates.positions_m[1, 1] < 0 < estimates.positions_m[2, 1]
    assert 0.05 < estimates.exchange_probability < 0.5


@pytest.mark.parametrize("fps", [1, 2, 3, 5, 10, 15, 30])
def test_the_same_movement_is_followed_at_every_frame_rate(fps):
    """Half a metre in a second and a half, as `fps_ladder` has it, without other parameters."""
    one, state = started(PARALLEL)
    for k in range(1, 3 * fps + 1):
        u = min(k / fps / 1.5, 1.0)
        way = 10 * u**3 - 15 * u**4 + 6 * u**5
        points = START_W + way * np.array([[0.0, 0, 0], [0.1, -0.2, 0.3], [0.1, 0.1, 0.4]])
        state, estimates = kept(one, state, points, AREAS, 1, 1 / fps)
        np.testing.assert_allclose(estimates.positions_m, points, atol=0.06)
    np.testing.assert_allclose(estimates.positions_m, points, atol=0.01)
