"""Painted pictures against rendered ones, and what is made of them."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.detector.clusters import ClusterParameters, cluster
from pjpdaf.detector.components import segments
from pjpdaf.detector.ellipses import moments
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from scenarios.play.recipe import sized
from scenarios.spec.draw import unjudged
from scenarios.spec.names import load_scenario
from sim.labels import merged
from sim.sequence import Simulation
from sim.silhouettes.clustering import chosen_clusters
from sim.silhouettes.error_model import BlobErrors, ErrorModel, error_model
from sim.silhouettes.film import film_of
from sim.silhouettes.painter import Painter
from sim.silhouettes.shapes import BARE, TARGET_PAINT
from sim.silhouettes.truths import Truths

APART, TOGETHER = 6, 17  # frames of `merge_and_hold` with hands apart, and as one blob


@pytest.fixture(scope="module")
def performance():
    return sized(unjudged(load_scenario("merge_and_hold"), 8000), (320, 240))


@pytest.fixture(scope="module")
def painter(performance):
    return Painter(film_of(performance, step_px=1, everything=True))


@pytest.mark.parametrize("frame", [APART, TOGETHER])
def test_targets_are_where_the_renderer_puts_them(performance, painter, frame):
    with Simulation(performance) as simulation:
        rendered = simulation.render(frame).truth
    painted = Truths(painter.film).of(frame, painter.paint(frame))
    np.testing.assert_array_equal(painted.centres_m.round(9), rendered.centres_m.round(9))
    for ours, theirs in zip(painted.views, rendered.views, strict=True):
        # At half the usual size: a pixel is two of the usual ones.
        np.testing.assert_allclose(ours.centroids_px, theirs.centroids_px, atol=1.2)
        np.testing.assert_allclose(ours.visible_px, theirs.visible_px, rtol=0.12)
        np.testing.assert_allclose(ours.amodal_px, theirs.amodal_px, rtol=0.12)
        np.testing.assert_array_equal(ours.merged, theirs.merged)
    together = painted.views[0].merged
    assert together[RIGHT_HAND, LEFT_HAND] == (frame == TOGETHER)
    assert not together[HEAD].any()
    assert len(painted.events) >= len(painted.script_events)


def test_a_fast_truth_merges_as_a_rendered_one(painter):
    view = painter.paint(TOGETHER)[0]
    targets = view.classes.astype(np.int8) - TARGET_PAINT
    targets[targets < 0] = -1
    truth = Truths(painter.film).of(TOGETHER, painter.paint(TOGETHER)).views[0]
    np.testing.assert_array_equal(truth.merged, merged(targets, truth.boxes_px))


def test_fewer_hypotheses_choose_as_all_of_them(painter):
    every = ClusterParameters(subsample=1)
    choices = []
    for frame in range(10, 24):
        for view in painter.paint(frame):
            mask = np.ascontiguousarray((view.classes >= BARE).view(np.uint8)[::2, ::2])
            seen = segments(mask, 20.0, True)
            ours, labels = chosen_clusters(seen, every), cluster(seen, every)
            theirs = moments(seen.points, labels, int(labels.max()) + 1)
            choices.append(len(theirs))
            np.testing.assert_array_equal(ours.centres, theirs.centres)
            np.testing.assert_array_equal(ours.areas, theirs.areas)
    assert len(set(choices)) > 1  # pictures with two and with three clusters


def test_frames_are_the_same_in_any_order(painter):
    film = painter.film
    forward = [painter.paint(i) for i in (3, 4, 5)]
    backward = Painter(film, kept=2)
    for i, there in zip((5, 4, 3), reversed(forward), strict=True):
        for a, b in zip(backward.paint(i), there, strict=True):
            np.testing.assert_array_equal(a.classes, b.classes)
            assert a.patches == b.patches


def test_errors_are_those_of_the_model():
    model = ErrorModel(own_px=0.3, shared_px=0.4)
    moves = BlobErrors(model, frames=2000, views=2, width_px=1280, seed=5)._moves_px
    left, right = moves[:, 0].reshape(-1), moves[:, 1].reshape(-1)
    # 32 000 draws: their deviation is known to 0.4 %. Pictures of twice the size: twice the error.
    assert np.std(left) == pytest.approx(2 * 0.5, rel=0.02)
    assert np.std(left - right) == pytest.approx(2 * 0.3 * 2**0.5, rel=0.02)
    again = BlobErrors(model, frames=2000, views=2, width_px=1280, seed=5)._moves_px
    np.testing.assert_array_equal(moves, again)


def test_every_preset_has_a_model():
    assert error_model("thesis").own_px > 0
    assert error_model("thesis_literal") == error_model("default")
