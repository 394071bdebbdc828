"""What a varied rig must see, and when a motion is sent back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pjpdaf.camera import project
from scenarios.spec.draw import concrete, in_si, unjudged
from scenarios.spec.in_view import out_of_view, sees_workspace
from scenarios.spec.names import load_scenario
from sim.motion.motion import Performer
from sim.scene.rig import stereo_rig


def values(**changes):
    scenario = load_scenario("calm_table")
    return in_si(scenario, concrete(scenario, 0, changes))


def test_the_nominal_rig_sees_the_workspace_and_one_that_looks_up_does_not():
    assert sees_workspace(values())
    assert not sees_workspace(values(rig_tilt=0.0, rig_height=1.6))
    assert not sees_workspace(values(focal=700, rig_distance=1.1))


def test_a_palm_out_of_either_picture_is_named_with_its_moment():
    performer = unjudged(load_scenario("natural_table"), 0).script
    assert isinstance(performer, Performer)
    times = np.linspace(0.0, 10.0, 60).tolist()
    assert out_of_view(performer, times) is None
    rig = replace(performer.scene.rig, focal_px=900.0)
    narrow = Performer(replace(performer.scene, rig=rig), performer.plan)
    fault = out_of_view(narrow, times)
    assert fault is not None
    assert "palm leaves the pictures: use another seed or rig" in fault
    side = 0 if "the right palm" in fault else 1
    moment = float(fault.split()[1])
    palm = performer.plan.hands[side].at(moment).position_m
    seen = [project(camera, palm) for camera in stereo_rig(rig).cameras]
    assert any(not (0 <= u <= 639 and 0 <= v <= 479) for u, v in seen)


def test_a_motion_that_leaves_the_view_on_purpose_is_not_judged():
    performer = unjudged(load_scenario("leave_view"), 0).script
    rig = replace(performer.scene.rig, focal_px=900.0)
    narrow = Performer(replace(performer.scene, rig=rig), performer.plan)
    assert out_of_view(narrow, np.linspace(0.0, 10.0, 60).tolist()) is None
