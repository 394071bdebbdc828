from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import project, to_camera
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from sim.camera.render import StereoRenderer, ViewRender
from sim.labels import (
    back_project,
    centres,
    merge_events,
    merged,
    truth_of,
    velocities,
    view_truth,
)
from sim.person.rest import rest_pose
from sim.scene.rig import stereo_rig
from sim.scene.world import build
from sim.specs import RigSpec, SceneSpec

SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28))


def view_of(targets, amodal=(100, 100, 100)):
    """A view whose amodal masks have so many pixels, wherever they are."""
    masks = np.arange(targets.size).reshape(targets.shape) < np.reshape(amodal, (3, 1, 1))
    return ViewRender(None, None, None, targets, masks)


def blobs(*boxes):
    """Targets (40, 60) with one rectangle x, y, width, height per target, None for none."""
    targets = np.full((40, 60), -1, np.int8)
    for target, box in enumerate(boxes):
        if box is not None:
            x, y, w, h = box
            targets[y : y + h, x : x + w] = target
    return targets


def test_centroid_count_and_box_of_a_rectangle():
    seen = view_truth(view_of(blobs((10, 20, 4, 3), None, (30, 5, 1, 1)), (24, 7, 0)))
    np.testing.assert_array_equal(seen.centroids_px[0], [11.5, 21.0])
    np.testing.assert_array_equal(seen.boxes_px[0], [10, 20, 4, 3])
    np.testing.assert_array_equal(seen.visible_px, [12, 0, 1])
    assert np.isnan(seen.centroids_px[1]).all()
    assert np.isnan(seen.boxes_px[1]).all()
    np.testing.assert_array_equal(seen.visible_fractions, [0.5, 0.0, 1.0])


@pytest.mark.parametrize(("gap", "together"), [(0, True), (1, True), (2, True), (3, False)])
def test_skin_closer_than_two_pixels_is_one_blob(gap, together):
    for second in ((15 + gap, 10, 5, 5), (10, 15 + gap, 5, 5)):
        seen = view_truth(view_of(blobs(None, (10, 10, 5, 5), second)))
        assert seen.merged[RIGHT_HAND, LEFT_HAND] == together
        assert not seen.merged[HEAD].any()


def test_a_chain_of_contacts_is_one_blob():
    seen = view_truth(view_of(blobs((15, 10, 5, 5), (10, 10, 5, 5), (20, 10, 5, 5))))
    np.testing.assert_array_equal(seen.merged, ~np.eye(3, dtype=bool))


def test_merging_does_not_depend_on_the_frame_around():
    targets = blobs((0, 0, 5, 5), (5, 0, 5, 5), None)
    boxes = view_truth(view_of(targets)).boxes_px
    assert merged(targets, boxes)[0, 1]


def test_merges_are_named_per_view():
    near = view_truth(view_of(blobs(None, (10, 10, 5, 5), (15, 10, 5, 5))))
    apart = view_truth(view_of(blobs((0, 0, 4, 4), (10, 10, 5, 5), (30, 10, 5, 5))))
    assert merge_events((near, apart)) == ("merge:right_hand+left_hand:left_view",)
    assert merge_events((apart, near)) == ("merge:right_hand+left_hand:right_view",)


def test_back_projection_undoes_projection():
    rig = stereo_rig(RigSpec(tilt_rad=0.2, vergence_rad=0.05, distortion=(-0.1, 0.02, 0, 0)))
    ideal = replace(rig.left, distortion=np.zeros(0))
    xs, ys = np.array([12, 320, 600]), np.array([30, 200, 470])
    depth = np.array([0.8, 1.3, 2.5], np.float32)
    for camera in (rig.left, ideal):
        points = back_project(camera, xs, ys, depth)
        np.testing.assert_allclose(to_camera(camera, points)[:, 2], depth, rtol=1e-6)
    np.testing.assert_allclose(project(ideal, points), np.column_stack([xs, ys]), atol=1e-6)


class Gliding:
    """Both hands move along y at 0.3 and -0.2 m/s, the head stands."""

    def pose(self, t_s):
        palms = ((0.34, -0.20 + 0.3 * t_s, 0.80), (0.34, 0.20 - 0.2 * t_s, 0.80))
        return rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)

    def events(self, t_s):
        return ("glide",)


def test_velocities_are_differences_of_the_script():
    for t_s in (0.0, 0.7):
        expected = [[0, 0, 0], [0, 0.3, 0], [0, -0.2, 0]]
        np.testing.assert_allclose(velocities(Gliding(), t_s), expected, atol=1e-9)


def test_the_truth_of_a_rendered_frame():
    script = Gliding()
    world = build(SCENE)
    with StereoRenderer(world) as renderer:
        truths = []
        for index, t_s in enumerate((0.0, 0.75)):
            pose = script.pose(t_s)
            world.place(pose)
            views = renderer.render(colour=False)
            cameras = world.rig.cameras
            events = script.events(t_s)
            truth = truth_of(index, pose, velocities(script, t_s), views, cameras, events)
            truths.append(truth)
    apart, joined = truths
    np.testing.assert_array_equal(apart.centres_m, centres(script.pose(0.0)))
    # The visible surface lies in front of the centre, by at most the part's own size.
    towards = world.rig.left.centre_w - apart.centres_m
    depth = np.sum((apart.surfaces_m - apart.centres_m) * towards, axis=1)
    depth /= np.linalg.norm(towards, axis=1)
    assert (depth > 0.0).all()
    assert (depth < 0.12).all()
    assert apart.events == ("glide",)
    assert not any(view.merged.any() for view in apart.views)
    assert "merge:right_hand+left_hand:left_view" in joined.events
    assert joined.views[0].merged[RIGHT_HAND, LEFT_HAND]
    for truth in truths:
        for view in truth.views:
            assert (view.visible_fractions <= 1).all()
            assert (view.visible_px <= view.amodal_px).all()
