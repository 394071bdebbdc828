"""Labels of real frames: what they must agree with, and that making them changes nothing."""

import cProfile
import pstats
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pjpdaf.camera import project
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.camera.rays import cast
from sim.dataset.labels.instances import FIRST_OBJECT, PERSON
from sim.dataset.labels.labeller import Labeller
from sim.dataset.labels.records import KEYPOINTS, NO_SURFACE, NOT_LABELLED, OCCLUDED, SEEN, VISIBLE
from sim.labels import centres, velocities
from sim.lens import real_pixels
from sim.person.rest import rest_pose
from sim.pose import Transform
from sim.script import Performance
from sim.sequence import Simulation
from sim.specs import ClockSpec, ObjectSpec, RigSpec, RoomSpec, SceneSpec, SensorSpec

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3), yaw_rad=4.0)
BOX = ObjectSpec("box", "box", (0.08, 0.10, 0.10), (0.1, 0.5, 0.1), (0.5, 0.1))
RIG = RigSpec(tilt_rad=0.28, focal_px=270.0, width_px=320, height_px=240)
SCENE = SceneSpec(rig=RIG, room=RoomSpec(objects=(CAN, BOX)))
BENT = (-0.2, 0.05, 0.001, -0.0008)
SEEDS = range(100, 110)
PALM = {target: KEYPOINTS.index((target, "palm_centre")) for target in (RIGHT_HAND, LEFT_HAND)}


class Sliding:
    """The right hand slides to the person's left at 1 m/s, the can along with it."""

    def pose(self, t_s):
        palms = ((0.34, -0.32 + 1.0 * t_s, 0.77), (0.34, 0.25, 0.77))
        pose = rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)
        at = Transform(np.array([0.5, -0.3 + t_s, 0.73]), Rotation.from_euler("z", t_s).as_matrix())
        return replace(pose, objects={"can": at})

    def events(self, t_s):
        return ()


class Leaving(Sliding):
    """The left hand leaves to the person's left, first cut by the border, then gone."""

    def pose(self, t_s):
        palms = ((0.34, -0.2, 0.77), (0.34, 0.45 + 0.3 * t_s, 0.9))
        return rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)


def performance(script=None, rig=RIG, sensor=None, clock=None):
    scene = replace(
        SCENE, rig=rig, sensor=sensor or SensorSpec(noise_sd=0.0), clock=clock or ClockSpec()
    )
    return Performance(scene, script or Sliding(), 20, 10.0, 1, seed=7)


@pytest.fixture(scope="module")
def plain():
    with Simulation(performance()) as simulation:
        yield simulation, Labeller(simulation).labelled(3)


def scenario_frame(name, index, seed=101):
    small = sized(perform(load_scenario(name), seed), (RIG.width_px, RIG.height_px))
    with Simulation(small) as simulation:
        labeller = Labeller(simulation, ())
        return labeller.labelled(index)


EFFECTS = SensorSpec(exposure_time_s=0.01, skew_s=0.03, noise_sd=2.0)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "playing",
    [
        performance(),
        performance(
            Leaving(),
            replace(RIG, vergence_rad=0.05, distortion=BENT),
            EFFECTS,
            ClockSpec(jitter_s=0.02, dropped=0.3),
        ),
    ],
    ids=["plain", "effects"],
)
def test_labels_change_no_byte_of_a_shot(playing):
    with Simulation(playing) as simulation:
        bare = [simulation.render(index) for index in range(8, 10)]
    with Simulation(playing) as simulation:
        labeller = Labeller(simulation)
        labelled = [labeller.labelled(index)[0] for index in (9, 8)][::-1]
    for one, other in zip(bare, labelled, strict=True):
        assert one.frame.time_s == other.frame.time_s
        assert one.hook_results == other.hook_results == (None, None)
        for mine, its in zip(one.frame.pictures, other.frame.pictures, strict=True):
            assert (mine is None) == (its is None)
            if mine is not None:
                np.testing.assert_array_equal(mine, its)
        for mine, its in zip(one.views, other.views, strict=True):
            for part in fields(mine):
                np.testing.assert_array_equal(getattr(mine, part.name), getattr(its, part.name))
        for name in ("time_s", "centres_m", "velocities_mps", "surfaces_m", "events"):
            np.testing.assert_array_equal(getattr(one.truth, name), getattr(other.truth, name))
        for mine, its in zip(one.truth.views, other.truth.views, strict=True):
            for part in fields(mine):
                np.testing.assert_array_equal(getattr(mine, part.name), getattr(its, part.name))


def test_any_order_gives_the_same_labels(plain):
    simulation, (_, first) = plain
    labeller = Labeller(simulation)
    labeller.labelled(0)
    _, again = labeller.labelled(3)
    np.testing.assert_array_equal(first.keypoints_m, again.keypoints_m)
    for one, other in zip(first.views, again.views, strict=True):
        for name in ("depth_m", "instances", "amodal", "truncation", "hidden_px", "keypoints_px"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        np.testing.assert_array_equal(one.matches.places_px, other.matches.places_px)
        np.testing.assert_array_equal(one.rectified.disparity_px, other.rectified.disparity_px)


def test_only_what_is_wanted_is_made(plain):
    simulation, _ = plain
    _, labels = Labeller(simulation, ["disparity"]).labelled(0)
    assert all(view.rectified is not None and view.matches is None for view in labels.views)
    _, labels = Labeller(simulation, ["correspondence"]).labelled(0)
    assert all(view.rectified is None and view.matches is not None for view in labels.views)
    _, labels = Labeller(simulation, ["semantic"]).labelled(0)
    assert all(view.classes is not None and view.normals is None for view in labels.views)
    _, labels = Labeller(simulation, ["normals"]).labelled(0)
    assert all(view.classes is None and view.normals is not None for view in labels.views)
    for wanted in ([name for name in Labeller.WANTED if name != "flow"], ["flow"]):
        labeller = Labeller(simulation, wanted)
        labeller.labelled(0)
        if "flow" in wanted:
            assert len(labeller.flow(0).forward) == len(labeller.flow(0).backward) == 2
        else:
            with pytest.raises(ValueError, match="the label flow was not wanted"):
                labeller.flow(0)
    with pytest.raises(ValueError, match=r"unknown labels \['warmth'\]; known: \['disparity', "):
        Labeller(simulation, ["warmth"])


# The code that makes a label of a frame: a module, or a function of one.
MAKERS = {
    "disparity": "labels/stereo.py:",
    "correspondence": "labels/stereo.py:",
    "normals": "camera/render.py:normals",
    "flow": "labels/flow.py:",
}


def makers_called(labeller):
    """The makers that ran while a frame was labelled."""
    with cProfile.Profile() as profile:
        labeller.labelled(1)
    called = [f"{file}:{name}" for file, _, name in pstats.Stats(profile).stats]
    return {maker for maker in MAKERS.values() if any(maker in code for code in called)}


def test_what_is_not_wanted_costs_nothing(plain):
    simulation, _ = plain
    assert makers_called(Labeller(simulation, ())) == set()
    assert makers_called(Labeller(simulation, ["semantic"])) == set()
    for label, maker in MAKERS.items():
        assert makers_called(Labeller(simulation, [label])) == {maker}


def test_depth_is_nan_exactly_where_nothing_is(plain):
    _, (shot, labels) = plain
    for view, said in zip(shot.views, labels.views, strict=True):
        np.testing.assert_array_equal(np.isnan(said.depth_m), view.geoms < 0)
        there = view.geoms >= 0
        np.testing.assert_array_equal(said.depth_m[there], view.depth_m[there])


def check_counts(shot, labels, slivers=2):
    """Visible and hidden pixels make up the amodal mask, but for slivers of an outline."""
    for truth, said in zip(shot.truth.views, labels.views, strict=True):
        whole = np.count_nonzero(said.amodal, axis=(1, 2))
        assert np.abs(truth.visible_px + said.hidden_px.sum(axis=1) - whole).max() <= slivers
        for target in range(3):
            assert said.hidden_px[target, 1 + target] == 0
            ys, xs = np.nonzero(said.amodal[target])
            if len(xs) == 0:
                assert np.isnan(said.amodal_boxes_px[target]).all()
                continue
            x, y, w, h = said.amodal_boxes_px[target]
            assert (x, y) == (xs.min(), ys.min())
            assert (x + w - 1, y + h - 1) == (xs.max(), ys.max())
        assert said.objects_px.tolist() == [
            np.count_nonzero(said.instances == FIRST_OBJECT + i)
            for i in range(len(said.objects_px))
        ]


def test_a_calm_person_shows_nearly_all():
    shot, labels = scenario_frame("calm_table", 20)
    check_counts(shot, labels)
    assert len(labels.objects) == len(labels.views[0].objects_px) == 2
    for said in labels.views:
        assert said.keypoint_status[list(PALM.values())].tolist() == [VISIBLE] * 2
        assert said.keypoint_status[:2].tolist() == [VISIBLE] * 2
        assert (said.keypoint_status == VISIBLE).mean() > 0.8
        assert said.truncation.tolist() == [0.0] * 3
        # A free head is whole; of a free hand its own sleeve covers a little.
        assert said.hidden_px[HEAD].sum() < 10
        assert said.hidden_px[LEFT_HAND, PERSON] < 20


def test_the_hand_at_the_face_is_what_hides_it():
    shot, labels = scenario_frame("touch_face", 20)
    check_counts(shot, labels)
    for said in labels.views:
        by = said.hidden_px[HEAD]
        hand = 1 + int(np.argmax(by[2:4])) + 1
        assert by[hand] > 25
        assert by[hand] > 0.95 * by.sum()


def test_the_head_hides_the_hand_behind_it():
    shot, labels = scenario_frame("hand_behind_head", 20)
    check_counts(shot, labels)
    gone = int(np.argmin(shot.truth.views[0].visible_px[1:])) + 1
    for said in labels.views:
        assert (said.amodal[gone]).sum() > 125
        assert said.hidden_px[gone, 1 + HEAD] > 125
        own = [k for k, (target, _) in enumerate(KEYPOINTS) if target == gone]
        assert (said.keypoint_status[own] == OCCLUDED).all()
        assert said.truncation[gone] == 0.0


def by_rays(simulation, view, target):
    """Truncation of a target by rays through a picture twice as wide and high."""
    world = simulation.world
    camera, lens = world.rig.cameras[view], world.lenses[view]
    ideal = replace(lens.ideal if lens else camera, distortion=np.zeros(0))
    w, h = ideal.width_px, ideal.height_px
    # The whole left of the picture is far from the hand: rays are cast near it alone.
    ys, xs = np.mgrid[: 2 * h, w : 2 * w]
    pixels = np.column_stack([xs.ravel() - w // 2, ys.ravel() - h // 2]).astype(float)
    geoms, _ = cast(world, ideal, pixels, (world.amodal_groups[target],))
    own = pixels[np.append(world.targets, -1)[geoms] == target]
    at = (own + camera.K[:2, 2] - ideal.K[:2, 2]).astype(np.float32)
    x, y = real_pixels(camera, lens, at[:, 0], at[:, 1])
    inside = (x >= -0.5) & (x < camera.width_px - 0.5)
    inside &= (y >= -0.5) & (y < camera.height_px - 0.5)
    return 1 - inside.mean()


@pytest.mark.sample(1)
@pytest.mark.parametrize("distortion", [(), BENT], ids=["pinhole", "lens"])
def test_truncation_is_the_share_beyond_the_border(distortion):
    rig = replace(RIG, distortion=distortion)
    shares, off = [], []
    with Simulation(performance(Leaving(), rig)) as simulation:
        labeller = Labeller(simulation, ())
        for index in (0, 7, 8, 9, 10, 19):
            shot, labels = labeller.labelled(index)
            check_counts(shot, labels)
            said = labels.views[1]  # the world still stands as for this view
            share = said.truncation[LEFT_HAND]
            shares.append(share)
            np.testing.assert_array_equal(said.truncation[[HEAD, RIGHT_HAND]], 0.0)
            if 0 < share < 1:
                off.append(abs(share - by_rays(simulation, 1, LEFT_HAND)))
            own = [k for k, (target, _) in enumerate(KEYPOINTS) if target == LEFT_HAND]
            outside = said.keypoint_status[own] == NOT_LABELLED
            assert outside.all() if share == 1 else not outside.all()
    print("truncation off by", off)
    assert max(off) < 0.005
    assert shares[0] == 0.0
    assert shares[-1] == 1.0
    assert (np.diff(shares) >= 0).all()
    assert sum(0.02 < share < 0.98 for share in shares) >= 2


def test_what_is_far_outside_is_truncated_whole():
    """So far out that even the picture of twice the size does not show it."""

    class Away(Sliding):
        def pose(self, t_s):
            pose = rest_pose(SCENE.anatomy)
            hand = Transform(np.array([0.34, 3.0, 0.9]), pose.hands[1].rotation)
            fore = Transform(np.array([0.1, 3.0, 0.9]), pose.forearms[1].rotation)
            hands, fores = (pose.hands[0], hand), (pose.forearms[0], fore)
            return replace(pose, hands=hands, forearms=fores)

    with Simulation(performance(Away(), RIG)) as simulation:
        _, labels = Labeller(simulation, ()).labelled(0)
    for said in labels.views:
        assert said.truncation.tolist() == [0.0, 0.0, 1.0]
        assert np.isnan(said.amodal_boxes_px[LEFT_HAND]).all()


def test_poses_are_those_of_the_shot(plain):
    simulation, (shot, labels) = plain
    parts = (shot.pose.head, *shot.pose.hands)
    turned = Rotation.from_quat(labels.quaternions, scalar_first=True).as_matrix()
    np.testing.assert_allclose(turned, [part.rotation for part in parts], atol=1e-12)
    assert (labels.quaternions[:, 0] >= 0).all()
    centre = [0, PALM[RIGHT_HAND], PALM[LEFT_HAND]]
    np.testing.assert_allclose(labels.keypoints_m[centre], shot.truth.centres_m)
    for said, camera in zip(labels.views, simulation.rig.cameras, strict=True):
        expected = project(camera, labels.keypoints_m)
        np.testing.assert_allclose(said.keypoints_px, expected, atol=1e-3)


def test_objects_are_where_they_are_drawn(plain):
    simulation, _ = plain
    shot, labels = Labeller(simulation, ()).labelled(3)  # poses the world
    world = simulation.world
    assert [thing.name for thing in labels.objects] == ["can", "box"]
    for thing in labels.objects:
        mocap = world.bodies[f"object:{thing.name}"]
        np.testing.assert_allclose(thing.position_m, world.data.mocap_pos[mocap], atol=1e-12)
        drawn = world.data.mocap_quat[mocap]
        assert abs(drawn @ thing.quaternion) == pytest.approx(1.0, abs=1e-9)
    can, box = labels.objects
    np.testing.assert_allclose(can.velocity_mps, [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(box.velocity_mps, 0, atol=1e-12)
    # As the truth has it of the hand that moves along.
    np.testing.assert_allclose(can.velocity_mps, shot.truth.velocities_mps[RIGHT_HAND], atol=1e-9)


def test_the_first_frame_has_one_sided_velocities():
    with Simulation(performance()) as simulation:
        shot, labels = Labeller(simulation, ()).labelled(0)
    np.testing.assert_allclose(labels.objects[0].velocity_mps, [0, 1, 0], atol=1e-9)
    np.testing.assert_array_equal(shot.truth.velocities_mps, velocities(Sliding(), 0.0))


@pytest.mark.sample(1)
@pytest.mark.parametrize("rig", [RIG, replace(RIG, vergence_rad=0.05)], ids=["own", "drawn"])
def test_with_skew_stereo_is_of_the_left_views_moment(rig):
    skew_s = 0.05
    with Simulation(performance(rig=rig)) as simulation:
        _, now = Labeller(simulation).labelled(3)
    with Simulation(performance(rig=rig, sensor=SensorSpec(0.0, skew_s, noise_sd=0.0))) as late:
        shot, skewed = Labeller(late).labelled(3)
    for one, other in zip(now.views, skewed.views, strict=True):
        for name in ("rectified", "matches"):
            mine, its = getattr(one, name), getattr(other, name)
            np.testing.assert_array_equal(mine.status, its.status)
        np.testing.assert_array_equal(one.rectified.disparity_px, other.rectified.disparity_px)
        np.testing.assert_array_equal(one.matches.places_px, other.matches.places_px)
    np.testing.assert_array_equal(now.keypoints_m, skewed.keypoints_m)
    # All else of the right view is of its own moment, and lies on its masks.
    moved = skewed.views[1].keypoints_px - now.views[1].keypoints_px
    palm = PALM[RIGHT_HAND]
    assert moved[palm, 0] == pytest.approx(270 * skew_s / 1.1, rel=0.2)
    assert np.abs(moved[PALM[LEFT_HAND]]).max() < 1e-6
    assert skewed.views[1].keypoint_status[palm] == VISIBLE
    np.testing.assert_array_equal(skewed.views[0].keypoints_px, now.views[0].keypoints_px)
    assert (skewed.views[1].depth_m != now.views[1].depth_m).any()
    np.testing.assert_allclose(shot.truth.centres_m, centres(Sliding().pose(0.3)))


def test_disparity_and_matches_say_the_same(plain):
    """The rig is parallel: both are of the same pixels."""
    _, (_, labels) = plain
    xs = np.arange(RIG.width_px)
    for said, sign in zip(labels.views, (-1, 1), strict=True):
        there = (said.matches.status != NO_SURFACE) & (said.rectified.status != NO_SURFACE)
        moved = (said.matches.places_px[..., 0] - xs)[there]
        np.testing.assert_allclose(moved, sign * said.rectified.disparity_px[there], atol=1e-3)
        assert (said.matches.status != said.rectified.status).mean() < 2e-3
        assert (said.matches.status == SEEN).mean() > 0.85
        bf = RIG.focal_px * 0.09
        depth = bf / said.rectified.disparity_px[there]
        np.testing.assert_allclose(depth, said.depth_m[there], rtol=1e-5)
