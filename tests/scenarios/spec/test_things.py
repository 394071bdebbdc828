"""Clutter keeps out of the motion's way, and a second person stands in the background."""

from __future__ import annotations

import numpy as np
import pytest

from pjpdaf.camera import project
from scenarios.play.targets import expand_target
from scenarios.spec.draw import perform
from scenarios.spec.in_view import out_of_view
from scenarios.spec.things import off_the_table, second_person
from sim.contact.arm_shape import arm_shape
from sim.contact.solids import StandingObject
from sim.motion.motion import object_at_rest, performer_of
from sim.scene.extras import NO_EXTRAS
from sim.scene.rig import stereo_rig
from sim.surroundings.clutter import BYSTANDER, outside_corner


@pytest.fixture(scope="module", params=["natural_table", "drink", "parallel"])
def played(request):
    """A performance in varied surroundings with something on its table."""
    (planned,) = (p for p in expand_target("varied") if p.label == request.param)
    return perform(planned.scenario, 0, {**planned.overrides, "clutter": 8})


def clutter(played):
    return [o for o in played.scene.room.objects if o.name.startswith("clutter_")]


def test_arms_as_they_are_posed_touch_no_clutter(played):
    performer, room = performer_of(played.script), played.scene.room
    things = [
        StandingObject(o.name, o.size_m, object_at_rest(room, o.name).position_m, o.yaw_rad, False)
        for o in clutter(played)
    ]
    assert things
    for t_s in np.linspace(0.0, played.frames / played.fps, 12).tolist():
        body = performer.body(t_s)
        for side, arm in enumerate(body.arms):
            shape = arm_shape(played.scene.anatomy, side, body.curls[side])
            for thing in things:
                assert thing.depth_m(shape.points(arm), shape.point_radii_m) < 0.0, thing.name


def test_clutter_lies_on_the_table_and_apart(played):
    room = played.scene.room
    things = clutter(played)
    for number, spec in enumerate(things):
        assert outside_corner(room, *spec.position_xy_m) < 0.0
        for other in things[:number]:
            gap = np.subtract(spec.position_xy_m, other.position_xy_m)
            assert np.hypot(*gap) > 0.5 * (min(spec.size_m[:2]) + min(other.size_m[:2]))
    assert off_the_table(played.scene) is None


def test_head_and_palms_are_in_both_pictures(played):
    performer = performer_of(played.script)
    times = np.linspace(0.0, played.frames / played.fps, 30).tolist()
    assert out_of_view(performer, times) is None
    for camera in stereo_rig(played.scene.rig).cameras:
        for t_s in times[::6]:
            body = performer.body(t_s)
            for point in (body.head.position_m, *(arm.palm_m for arm in body.arms)):
                u, v = project(camera, point)
                assert -5 < u < camera.width_px + 5
                assert -5 < v < camera.height_px + 5


def test_the_same_seed_gives_the_same_scene():
    (planned,) = (p for p in expand_target("varied") if p.label == "drink")
    first, again = (perform(planned.scenario, 1, planned.overrides).scene for _ in range(2))
    assert first == again


def test_a_second_person_who_moves_does_so_behind_the_first():
    (planned,) = (p for p in expand_target("varied") if p.label == "calm_table")
    changes = {**planned.overrides, "bystander": "moving", "room_depth": 2.2}
    played = perform(planned.scenario, 0, changes)
    assert [o.name for o in played.scene.room.objects if o.kind == "bystander"] == [BYSTANDER]
    places = np.array(
        [played.script.pose(t).objects[BYSTANDER].position_m for t in (0.0, 1.0, 2.0)]
    )
    assert np.ptp(places[:, 1]) > 0.01
    assert (places[:, 0] < -0.5).all()
    assert (places[:, 0] > -2.2).all()
    assert BYSTANDER not in played.learnt
    assert second_person(None, np.random.default_rng(0)) is NO_EXTRAS
