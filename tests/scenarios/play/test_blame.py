"""Blame: the stage whose replacement by truth cures a swap or a loss."""

from dataclasses import replace

import numpy as np
from point_episodes import (
    CAMERAS,
    FPS,
    HEAD,
    Frozen,
    all_seen,
    apart,
    crossing,
    episode_of,
    merging,
    tracker_of,
)
from strategies import minimum_jerk

from pjpdaf.camera import project
from pjpdaf.interfaces import Detections, Estimates
from reports.score.events import find_events
from scenarios.play.blame import NONE, blame, with_blame
from scenarios.play.oracle import STAGES, Oracle, track_again


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


def test_a_plug_in_that_gives_nothing_is_to_blame_itself():
    episode = episode_of(apart, all_seen, frames=8)
    lost = replace(
        episode,
        frames=tuple(replace(o, estimates=Estimates.waiting()) for o in episode.frames),
    )
    blamed = blame(lost, CAMERAS, Frozen())
    assert set(blamed.values()) == {NONE}
    assert with_blame(lost, CAMERAS, Frozen()).blame == blamed
