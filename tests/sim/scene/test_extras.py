"""Things that move or change by themselves, and what disturbs a scene."""

from dataclasses import replace
from types import MappingProxyType

import cv2
import numpy as np
import pytest

from pjpdaf.camera import to_camera
from sim.camera.render import StereoRenderer
from sim.person.rest import rest_pose
from sim.randomness import generator
from sim.scene.disturbances import (
    ABSENT,
    CHANGES,
    MOVERS,
    SHADOWS,
    background_change,
    mover,
    moving_shadow,
    together,
)
from sim.scene.extras import NO_EXTRAS, Extras, WithExtras
from sim.scene.rig import stereo_rig
from sim.scene.world import build
from sim.specs import RigSpec, RoomSpec, SceneSpec

RIG = RigSpec(tilt_rad=0.28)
SMALL = replace(RIG, width_px=320, height_px=240, focal_px=RIG.focal_px / 2)
SKIN = (0.84, 0.58, 0.45)
DURATION_S = 16.0


def rng(seed):
    return generator(seed, "disturbance")


def disturbance(kind, seed=100, azimuth_rad=0.0):
    """The extras of any one word."""
    if kind in SHADOWS:
        return moving_shadow(kind, azimuth_rad, rng(seed), DURATION_S)
    if kind in MOVERS:
        return mover(kind, SKIN, 0.73, 0.16, rng(seed), DURATION_S)
    return background_change(kind, 0.16, rng(seed))


ALL = tuple(k for k in (*SHADOWS, *MOVERS, *CHANGES) if k != "none")
MOVING = tuple(k for k in (*SHADOWS, *MOVERS) if k != "none")


class Still:
    """A script that rests."""

    def pose(self, t_s):
        return rest_pose(SceneSpec().anatomy, time_s=t_s)

    def events(self, t_s):
        return ("resting",)


def scene_with(extras, rig=RIG):
    return SceneSpec(rig=rig, room=RoomSpec(objects=extras.objects))


def test_the_extras_places_are_added_to_the_scripts_pose():
    extras = disturbance("balloon")
    script = WithExtras(Still(), extras)
    pose = script.pose(1.25)
    assert set(pose.objects) == {"balloon"}
    at = extras.tracks["balloon"].at(1.25)
    np.testing.assert_array_equal(pose.objects["balloon"].position_m, at.position_m)
    assert script.events(0.0) == ("resting",)


@pytest.mark.parametrize("words", [("shadow", moving_shadow), ("mover", mover)])
def test_an_unknown_word_is_refused(words):
    name, make = words
    arguments = (0.0,) if make is moving_shadow else (SKIN, 0.73, 0.16)
    with pytest.raises(ValueError, match=f"{name} must be one of none, .*, got 'ghost'"):
        make("ghost", *arguments, rng(100), DURATION_S)
    with pytest.raises(ValueError, match=r"background_change must be one of none, .*, got 'ghost'"):
        background_change("ghost", 0.16, rng(100))


def test_nothing_is_nothing():
    assert together(disturbance("none") for _ in range(3)) is NO_EXTRAS


def test_all_disturbances_go_together():
    chosen = [disturbance(k) for k in ("slow", "arm", "box")]
    both = together(chosen)
    assert {o.name for o in both.objects} == {"shadow_screen", "other_arm", "changed_box"}
    assert set(both.tracks) == {"shadow_screen", "other_arm"}
    assert set(both.learnt) == {o.name for o in both.objects}
    build(scene_with(both))


@pytest.mark.long
@pytest.mark.parametrize("kind", MOVING)
def test_a_track_is_pure_smooth_and_not_too_fast(kind):
    for seed in range(100, 110):
        (track,) = disturbance(kind, seed).tracks.values()
        times = np.arange(0.0, DURATION_S, 0.01)
        path = np.array([track.at(t).position_m for t in times])
        np.testing.assert_array_equal(path[::-1], [track.at(t).position_m for t in times[::-1]])
        speed = np.linalg.norm(np.diff(path, axis=0), axis=1) / 0.01
        assert speed.max() < 2.5
        assert np.abs(np.diff(speed)).max() < 0.08  # no jumps of the speed
        assert np.ptp(path, axis=0).max() > 0.3


def test_a_short_sequence_sees_it_come_and_go():
    track = mover("arm", SKIN, 0.73, 0.16, rng(100), 4.0).tracks["other_arm"]
    np.testing.assert_allclose(
        track.at(4.0).position_m, track.at(0.0).position_m, atol=0.02
    )  # but for the bob


def room_without_person(world, pose):
    """The left picture of the room."""
    world.place(pose)
    with StereoRenderer(world) as renderer:
        return renderer.render(labels=False, amodal=False, person=False)[0].colour


@pytest.fixture(scope="module")
def undisturbed():
    return room_without_person(build(scene_with(Extras(), SMALL)), rest_pose(SceneSpec().anatomy))


@pytest.mark.sample(2)
@pytest.mark.parametrize("kind", ALL)
def test_what_disturbs_is_absent_while_the_background_is_learnt(undisturbed, kind):
    extras = disturbance(kind)
    assert [o.name for o in extras.objects] == list(extras.learnt)
    assert all(place is ABSENT for place in extras.learnt.values())
    world = build(scene_with(extras, SMALL))
    assert set(world.targets.tolist()) == {-1, 0, 1, 2}
    learnt = replace(rest_pose(SceneSpec().anatomy), objects=extras.learnt)
    np.testing.assert_array_equal(room_without_person(world, learnt), undisturbed)


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", [k for k in CHANGES if k != "none"])
def test_the_learnt_background_differs_where_the_change_is_and_nowhere_else(kind):
    extras = disturbance(kind)
    world = build(scene_with(extras))
    pose = rest_pose(SceneSpec().anatomy)
    with StereoRenderer(world) as renderer:
        world.place(pose)
        now = renderer.render(amodal=False, person=False)[0]
        world.place(replace(pose, objects=extras.learnt))
        learnt = renderer.render(amodal=False, person=False)[0]
    changed = (now.colour != learnt.colour).any(axis=-1)
    thing = now.geoms != learnt.geoms
    assert thing.sum() > 500
    assert changed[thing].mean() > 0.95
    # Beside its silhouette there is its shadow, nothing else: darker, and no more than that.
    beside = changed & ~(cv2.dilate(thing.astype(np.uint8), np.ones((3, 3))) > 0)
    assert beside.sum() < 1.5 * thing.sum()
    brighter = now.colour[beside].sum(axis=-1) > learnt.colour[beside].sum(axis=-1)
    assert brighter.sum() < 0.01 * thing.sum()


def outside(camera, points_m):
    """Whether all points lie behind the camera, or all past the same side of its picture."""
    x, y, z = to_camera(camera, points_m).T
    (fx, _, cx), (_, fy, cy) = camera.K[:2]
    past = (
        z < 0,
        fx * x + (cx + 0.5) * z < 0,
        fx * x + (cx + 0.5 - camera.width_px) * z > 0,
        fy * y + (cy + 0.5) * z < 0,
        fy * y + (cy + 0.5 - camera.height_px) * z > 0,
    )
    return any(side.all() for side in past)


def corners(thing, place):
    sx, sy, sz = thing.size_m
    box = np.array([(x, y, z) for x in (-sx, sx) for y in (-sy, sy) for z in (0, 2 * sz)]) / 2
    return place.position_m + box @ place.rotation.T


@pytest.mark.long
def test_no_camera_ever_sees_what_casts_the_shadow():
    rigs = [
        stereo_rig(RigSpec(focal, baseline, height, distance, tilt))
        for focal, baseline in ((420.0, 0.30), (700.0, 0.06))
        for height in (1.2, 1.6)
        for distance in (1.1, 1.7)
        for tilt in (0.0, 0.44)
    ]
    for kind in ("slow", "fast"):
        for azimuth in np.radians([-45, -20, 0, 20, 45]):
            for seed in range(100, 104):
                extras = disturbance(kind, seed, azimuth)
                (thing,), (track,) = extras.objects, extras.tracks.values()
                for t in np.linspace(0, 13, 27):
                    points = corners(thing, track.at(t))
                    assert all(outside(c, points) for rig in rigs for c in rig.cameras)


@pytest.mark.sample(1)
@pytest.mark.parametrize("azimuth_deg", [-30.0, 0.0, 30.0])
def test_the_shadow_sweeps_over_table_hands_and_face_and_away(azimuth_deg):
    extras = disturbance("slow", azimuth_rad=np.radians(azimuth_deg))
    (track,) = extras.tracks.values()
    room = RoomSpec(objects=extras.objects, light_azimuth_rad=np.radians(azimuth_deg))
    world = build(SceneSpec(rig=SMALL, room=room))
    pose = rest_pose(SceneSpec().anatomy)
    with StereoRenderer(world) as renderer:
        world.place(replace(pose, objects=extras.learnt))
        clear = renderer.render(amodal=False)[0]
        darkest = []
        for share in (0.0, 0.18, 0.25, 0.32, 0.5):
            at = track.at(share * track.period_s)
            world.place(replace(pose, objects=MappingProxyType({"shadow_screen": at})))
            view = renderer.render(labels=False, amodal=False)[0]
            dark = view.colour.mean(axis=-1) < 0.8 * clear.colour.mean(axis=-1)
            table = clear.geoms == world.model.geom("table:top").id
            darkest.append(
                [dark[table].mean(), *(dark[clear.targets == t].mean() for t in range(3))]
            )
    swept = np.array(darkest)
    assert (swept[[0, -1], 1:] < 0.05).all()  # at either end the person is in the light
    assert (swept.max(axis=0)[1:] > 0.3).all()
    assert 0.08 < swept[:, 0].max() < 0.6


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", ["arm", "balloon"])
def test_the_mover_is_seen_comes_from_beside_and_is_of_the_colour_of_skin(kind):
    extras = disturbance(kind)
    ((name, track),) = extras.tracks.items()
    world = build(scene_with(extras))
    pose = rest_pose(SceneSpec().anatomy)
    seen, colours = [], []
    with StereoRenderer(world) as renderer:
        for share in (0.0, 0.25, 0.5):
            at = track.at(share * track.period_s)
            world.place(replace(pose, objects=MappingProxyType({name: at})))
            view = renderer.render(amodal=False)[0]
            mine = [
                g
                for g in range(world.model.ngeom)
                if world.model.geom(g).name.startswith(f"object:{name}")
                and not world.model.geom(g).name.endswith((":sleeve", ":string"))
            ]
            mask = np.isin(view.geoms, mine)
            seen.append(int(mask.sum()))
            assert (view.targets[mask] == -1).all()
            colours.append(view.colour[mask])
            hands = view.colour[view.targets > 0]
    assert max(seen) > 1200  # more than the smallest blob that a detector takes for a hand
    if kind == "arm":
        assert seen[0] == 0
        assert seen[2] == max(seen)
    theirs, ours = (
        cv2.cvtColor(c[None].astype(np.float32) / 255, cv2.COLOR_BGR2HSV)[0]
        for c in (np.concatenate(colours), hands)
    )
    np.testing.assert_allclose(np.median(theirs, axis=0)[:2], np.median(ours, axis=0)[:2], rtol=0.1)
