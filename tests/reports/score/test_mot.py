import datetime
import math

import motmetrics
import numpy as np
import pytest
from stonesoup.metricgenerator.ospametric import GOSPAMetric
from stonesoup.types.state import State
from trackeval.metrics import CLEAR, HOTA, Identity

from reports.score.gospa import CUT_OFF_M, gospa
from reports.score.mot import (
    MATCH_M,
    clear_mot,
    distances,
    hota,
    identity,
    summed_clear,
    summed_hota,
    summed_identity,
)

CASES = [*range(50), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(50, 200))]


def case(seed, gaps=True):
    """Targets that wander, tracks that follow, lose, swap and invent; NaN where there is none."""
    rng = np.random.default_rng(seed)
    F, T, K = int(rng.integers(5, 40)), int(rng.integers(1, 5)), int(rng.integers(1, 6))
    truths = np.cumsum(rng.normal(0, 0.05, (F, T, 3)), axis=0) + rng.normal(0, 0.2, (T, 3))
    tracks = rng.normal(0, 0.4, (F, K, 3))
    for k in range(min(T, K)):
        tracks[:, k] = truths[:, k] + rng.normal(0, rng.uniform(0.01, 0.15), (F, 3))
    if min(T, K) > 1 and rng.random() < 0.6:
        at = int(rng.integers(F))
        tracks[at:, [0, 1]] = tracks[at:, [1, 0]]
    if gaps:
        truths[rng.random((F, T)) < 0.15] = np.nan
        tracks[rng.random((F, K)) < 0.2] = np.nan
    return truths, tracks


def by_frame(truths, tracks):
    for truth, track in zip(truths, tracks, strict=True):
        there, said = np.isfinite(truth[:, 0]), np.isfinite(track[:, 0])
        yield np.flatnonzero(there), np.flatnonzero(said), truth[there], track[said]


def motmetrics_summary(truths, tracks):
    accumulator = motmetrics.MOTAccumulator(auto_id=True)
    for targets, ids, truth, track in by_frame(truths, tracks):
        far = np.linalg.norm(truth[:, None] - track[None], axis=-1)
        accumulator.update(targets, ids, np.where(far <= MATCH_M, far, np.nan))
    names = ["mota", "motp", "num_switches", "num_misses", "num_false_positives", "idf1", "idtp"]
    return motmetrics.metrics.create().compute(accumulator, metrics=names).iloc[0]


def trackeval_data(truths, tracks, zero_m):
    frames = list(by_frame(truths, tracks))
    # Its ids have no gaps: only those that ever appear, numbered anew.
    seen = [sorted({i for frame in frames for i in frame[k].tolist()}) for k in (0, 1)]
    ids = [[np.array([seen[k].index(i) for i in f[k]], dtype=int) for f in frames] for k in (0, 1)]
    similar = [
        np.maximum(0, 1 - np.linalg.norm(f[2][:, None] - f[3][None], axis=-1) / zero_m)
        for f in frames
    ]
    return {
        "gt_ids": ids[0],
        "tracker_ids": ids[1],
        "similarity_scores": similar,
        "num_gt_dets": sum(map(len, ids[0])),
        "num_tracker_dets": sum(map(len, ids[1])),
        "num_gt_ids": len(seen[0]),
        "num_tracker_ids": len(seen[1]),
        "num_timesteps": len(frames),
    }


@pytest.mark.parametrize("seed", CASES)
def test_clear_mot_and_idf1_are_those_of_motmetrics(seed):
    truths, tracks = case(seed)
    theirs = motmetrics_summary(truths, tracks)
    ours = clear_mot(truths, tracks)
    assert ours.switches == theirs["num_switches"]
    assert ours.misses == theirs["num_misses"]
    assert ours.false_positives == theirs["num_false_positives"]
    assert ours.mota == pytest.approx(theirs["mota"], abs=1e-9)
    assert ours.motp_m == pytest.approx(theirs["motp"], abs=1e-9, nan_ok=True)
    assert identity(truths, tracks).idf1 == pytest.approx(theirs["idf1"], abs=1e-9)


@pytest.mark.parametrize("seed", CASES)
def test_hota_and_identity_are_those_of_trackeval(seed):
    truths, tracks = case(seed)
    data = trackeval_data(truths, tracks, 2 * MATCH_M)
    theirs = HOTA().eval_sequence(data)
    ours = hota(truths, tracks)
    assert ours.hota == pytest.approx(float(np.mean(theirs["HOTA"])), abs=1e-9)
    np.testing.assert_allclose(ours.detection_accuracy, theirs["DetA"], atol=1e-9)
    np.testing.assert_allclose(ours.association_accuracy, theirs["AssA"], atol=1e-9)
    # A similarity of 0.5 is a distance of MATCH_M.
    ids = Identity({"THRESHOLD": 0.5, "PRINT_CONFIG": False}).eval_sequence(data)
    assert identity(truths, tracks).idf1 == pytest.approx(ids["IDF1"], abs=1e-9)


@pytest.mark.parametrize("seed", CASES)
def test_clear_mot_is_that_of_trackeval_while_no_target_goes_unmatched(seed):
    """Where one does, trackeval forgets its pairing after a frame; motmetrics, and we, do not."""
    rng = np.random.default_rng(seed)
    F, T = int(rng.integers(5, 40)), int(rng.integers(2, 5))
    apart = np.zeros((T, 3))
    apart[:, 0] = np.arange(T)
    truths = np.cumsum(rng.normal(0, 0.02, (F, T, 3)), axis=0) + apart
    tracks = truths + rng.uniform(-0.05, 0.05, (F, T, 3))
    for at in rng.integers(0, F, 3):
        tracks[at:] = tracks[at:, rng.permutation(T)]
    counts = clear_mot(truths, tracks)
    theirs = CLEAR({"THRESHOLD": 0.5, "PRINT_CONFIG": False}).eval_sequence(
        trackeval_data(truths, tracks, 2 * MATCH_M)
    )
    assert counts.switches == theirs["IDSW"]
    assert counts.mota == pytest.approx(theirs["MOTA"], abs=1e-9)
    assert counts.mota == pytest.approx(motmetrics_summary(truths, tracks)["mota"], abs=1e-9)


@pytest.mark.parametrize("seed", CASES)
def test_gospa_is_that_of_stone_soup(seed):
    truths, tracks = case(seed)
    metric = GOSPAMetric(p=2, c=CUT_OFF_M)
    now = datetime.datetime(2020, 1, 1, tzinfo=datetime.UTC)
    for ours, (_, _, truth, track) in zip(
        gospa(truths, tracks), by_frame(truths, tracks), strict=True
    ):
        states = [[State(p.reshape(3, 1), timestamp=now) for p in part] for part in (track, truth)]
        if not states[0] and not states[1]:
            assert ours.distance_m == 0
            continue
        theirs, _ = metric.compute_gospa_metric(states[0], states[1])
        assert ours.distance_m == pytest.approx(theirs.value["distance"], abs=1e-9)
        assert ours.missed == pytest.approx(theirs.value["missed"], abs=1e-9)
        assert ours.false == pytest.approx(theirs.value["false"], abs=1e-9)


def test_sums_are_those_of_trackeval():
    parts = [case(seed) for seed in range(6)]
    theirs = HOTA().combine_sequences(
        {str(i): HOTA().eval_sequence(trackeval_data(*p, 2 * MATCH_M)) for i, p in enumerate(parts)}
    )
    ours = summed_hota([hota(*part) for part in parts])
    assert ours.hota == pytest.approx(float(np.mean(theirs["HOTA"])), abs=1e-9)
    clear = summed_clear([clear_mot(*part) for part in parts])
    assert clear.truths == sum(int(np.isfinite(t[..., 0]).sum()) for t, _ in parts)
    ids = summed_identity([identity(*part) for part in parts])
    assert ids.true_positives == sum(identity(*part).true_positives for part in parts)


def test_tracks_swapped_from_the_first_frame_on_look_perfect_by_these_scores():
    truths = np.stack([[[0.0, 0.2, 1.0], [0.0, -0.2, 1.0]]] * 20)
    swapped = truths[:, ::-1]
    assert clear_mot(truths, swapped).mota == 1.0
    assert identity(truths, swapped).idf1 == 1.0
    assert hota(truths, swapped).hota == 1.0


def test_nothing_said_and_nothing_there():
    nothing = np.full((4, 2, 3), np.nan)
    some = np.zeros((4, 2, 3)) + np.arange(2)[:, None]
    assert clear_mot(some, nothing).mota == 0.0
    assert identity(some, nothing).idf1 == 0.0
    assert hota(some, nothing).hota == 0.0
    assert math.isnan(clear_mot(nothing, nothing).mota)
    assert math.isnan(identity(nothing, nothing).idf1)
    assert np.isnan(distances(some, nothing)).all()
