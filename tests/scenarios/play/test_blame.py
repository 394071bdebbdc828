"""Episodes of points, not pictures: truth, detections and a real tracker, tracked again."""

from dataclasses import replace

import numpy as np
import pytest
from strategies import FOCAL_PX, PointWorld, minimum_jerk, rig

from pjpdaf.camera import project
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.registry import make_tracker
from reports.score.events import find_events
from reports.score.records import Episode, FrameOutcome
from scenarios.play.blame import NONE, blame
from scenarios.play.oracle import STAGES, Oracle, stages_of, track_again, true_assignment
from sim.truth import Truth, ViewTruth

FPS = 3.0
CAMERAS = rig().cameras
HEAD = np.array([0.0, 0.0, 1.2])


def tracker_of(preset="thesis"):
    return make_tracker(preset, CAMERAS, {})


def truth_of(index, motion):
    t = index / FPS
    centres = motion(t)
    velocities = (motion(t + 1e-3) - motion(t - 1e-3)) / 2e-3
    views = tuple(
        ViewTruth(
            centroids_px=(pixels := project(camera, centres)),
            visible_px=np.array([4000, 1500, 1500]),
            amodal_px=np.array([4000, 1500, 1500]),
            boxes_px=np.column_stack([pixels - 20, np.full((3, 2), 40.0)]),
            merged=np.zeros((3, 3), dtype=bool),
        )
        for camera in CAMERAS
    )
    return Truth(index, t, centres, velocities, centres, views)


def episode_of(motion, see, frames=40, tracker=None):
    """What a tracker makes of what `see(index, truth)` lets it see."""
    tracker = tracker or tracker_of()
    blank = Episode(
        "points",
        "test",
        0,
        FPS,
        CAMERAS,
        tuple(
            FrameOutcome(truth := truth_of(i, motion), Estimates.waiting(), see(i, truth))
            for i in range(frames)
        ),
    )
    return track_again(blank, CAMERAS, tracker, Oracle())


def all_seen(index, truth):
    return PointWorld(noise_px=0.3, miss=0, clutter=0).see(
        CAMERAS, truth.centres_m, np.random.default_rng(index)
    )


def apart(t):
    return np.array([HEAD, [0.3, -0.2, 0.85], [0.3, 0.2, 0.85]])


def crossing(t):
    """The hands pass each other, 8 cm apart in depth, in about a second."""
    u = minimum_jerk((t - 4.0) / 1.6)
    return np.array([HEAD, [0.34, -0.2 + 0.4 * u, 0.85], [0.26, 0.2 - 0.4 * u, 0.86]])


def merging(index, truth):
    """One blob for two hands nearer than 60 px, as a camera sees it."""
    return PointWorld(noise_px=0.3, miss=0, clutter=0, merge_px=60).see(
        CAMERAS, truth.centres_m, np.random.default_rng(index)
    )


def test_nothing_wrong_nobody_to_blame():
    episode = episode_of(apart, all_seen)
    assert find_events(episode) == ()
    assert blame(episode, CAMERAS, tracker_of()) == {}


def test_hands_that_bounce_where_the_filter_goes_on_are_the_fault_of_a_stage_that_cures_it():
    episode = episode_of(crossing, merging)
    wrong = {(e.kind, e.target, e.first) for e in find_events(episode) if e.kind != "recovered"}
    assert wrong, "the tracker of the thesis swaps hands that cross"
    blamed = blame(episode, CAMERAS, tracker_of())
    assert set(blamed) == wrong
    for (kind, target, first), stage in blamed.items():
        assert stage in STAGES
        again = track_again(episode, CAMERAS, tracker_of(), Oracle(**{stage: True}))
        assert not any(e.kind == kind and e.target == target for e in find_events(again)), first
        # No earlier stage cures it.
        for other in STAGES[: STAGES.index(stage)]:
            again = track_again(episode, CAMERAS, tracker_of(), Oracle(**{other: True}))
            assert any(e.kind == kind and e.target == target for e in find_events(again))


def test_a_hand_that_the_detector_does_not_see_is_the_detectors_fault():
    def away(t):
        u = minimum_jerk((t - 3.0) / 2.0)
        return np.array([HEAD, [0.3, -0.2 - 0.25 * u, 0.85], [0.3, 0.2, 0.85]])

    def blind(index, truth):
        seen = all_seen(index, truth)
        if index < 10:
            return seen
        right = [project(camera, truth.centres_m[1]) for camera in CAMERAS]
        return tuple(without(view, pixel) for view, pixel in zip(seen, right, strict=True))

    def without(view, pixel):
        kept = np.linalg.norm(view.centres_px - pixel, axis=1) > 10
        return Detections(
            view.centres_px[kept],
            view.covariances_px2[kept],
            view.ellipses[kept],
            view.areas_px[kept],
        )

    episode = episode_of(away, blind)
    blamed = blame(episode, CAMERAS, tracker_of())
    assert {stage for (kind, target, _), stage in blamed.items() if target == 1} == {"detections"}
    assert any(kind == "lost" for kind, _, _ in blamed)


def test_a_hand_faster_than_any_gate_is_the_fault_of_association_or_process():
    def fast(t):
        leg = int(max(0.0, t - 4.0) // (1 / FPS)) % 2
        x = 0.5 * leg if t > 4 else 0.0
        return np.array([HEAD, [0.3, -0.2 - x, 0.85], [0.3, 0.2, 0.85]])

    episode = episode_of(fast, all_seen, tracker=tracker_of("thesis-literal"))
    blamed = blame(episode, CAMERAS, tracker_of("thesis-literal"))
    stages = {stage for (kind, target, _), stage in blamed.items() if kind == "lost"}
    assert stages, "a hand that jumps half a metre a frame is lost"
    assert "detections" not in stages
    assert stages <= {"association", "process", NONE}


def test_true_assignment_gives_each_target_its_own_detection_whatever_their_order():
    truth = truth_of(0, apart)
    seen = all_seen(0, truth)
    assigned = true_assignment(truth, seen, CAMERAS)
    for n, camera in enumerate(CAMERAS):
        wanted = project(camera, truth.centres_m)
        assert np.linalg.norm(assigned[n] - wanted, axis=1).max() < 2


def test_a_merged_blob_belongs_to_neither_hand():
    truth = truth_of(0, lambda t: np.array([HEAD, [0.3, -0.052, 0.85], [0.3, 0.052, 0.85]]))
    seen = merging(0, truth)
    assert [len(view) for view in seen] == [2, 2]
    gap_px = 0.104 * FOCAL_PX  # at 1 m
    assert gap_px / 2 > 25
    assigned = true_assignment(truth, seen, CAMERAS)
    assert np.isnan(assigned[:, 1:]).all()
    assert np.isfinite(assigned[:, 0]).all()


def test_a_missing_picture_stays_missing():
    def one_eyed(index, truth):
        seen = all_seen(index, truth)
        return (seen[0], Detections.none(missing=True)) if index > 5 else seen

    episode = episode_of(apart, one_eyed, frames=12)
    again = track_again(episode, CAMERAS, tracker_of(), Oracle(detections=True))
    assert [o.detections[1].missing for o in again.frames] == [i > 5 for i in range(12)]


def test_of_a_plug_in_only_the_detections_can_be_replaced():
    class Frozen:
        def start(self, seen):
            return 0

        def estimates(self, state):
            return Estimates.waiting()

        def predict(self, state, dt_s):
            return Estimates.waiting()

        def step(self, state, seen, dt_s):
            return state, Estimates.waiting()

    assert stages_of(Frozen()) == ("detections",)
    episode = episode_of(apart, all_seen, frames=8)
    lost = replace(
        episode,
        frames=tuple(replace(o, estimates=Estimates.waiting()) for o in episode.frames),
    )
    assert set(blame(lost, CAMERAS, Frozen()).values()) == {NONE}
    with pytest.raises(ValueError, match="PJPDAF only"):
        track_again(episode, CAMERAS, Frozen(), Oracle(association=True))
