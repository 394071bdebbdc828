"""Scripts as they are played: possible, still at first, timed as written, the same as by hand."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from performances import performance
from scripts import script

from pjpdaf.camera import project
from scenarios.spec.draw import judged, perform, unjudged
from scenarios.spec.names import load_scenario
from sim.contact.contact import Unposable
from sim.families.gestures.registry import GESTURES
from sim.labels import centres
from sim.scene.rig import stereo_rig

EXAMPLES = Path(__file__).parents[4] / "examples" / "motion"

# Each gesture at least once; the numbers are the gestures' own.
EVERY = (
    "{who: right, do: grasp, object: can, speed: 0.6}",
    "{who: right, do: lift, up: 0.1}",
    "{who: right, do: circle, duration: 1.5, rate: 1}",
    "{who: right, do: carry, to: {table: [0.42, 0.2, 0.05]}, speed: 0.5}",
    "{who: right, do: put, to: {table: [0.44, 0.2]}}",
    "{who: right, do: rest, name: put_down}",
    "{who: head, do: look, to: {object: can}, hold: 1}",
    "{who: head, do: nod}",
    "{who: head, do: shake}",
    "{who: head, do: lean, forward: 0.15}",
    "{who: head, do: lean}",
    "{who: left, do: touch, what: cheek, after: put_down, speed: 0.8}",
    "{who: left, do: rest}",
    "{who: left, do: touch, what: other_hand, speed: 0.8}",
    "{who: left, do: rest}",
    "{who: both, do: cross}",
    "{who: both, do: bounce}",
    "{who: both, do: clasp}",
    "{who: both, do: rest}",
    "{who: left, do: hide, object: screen}",
    "{who: left, do: rest}",
    "{who: left, do: leave_view}",
    "{who: left, do: rest, name: back}",
    "{who: right, do: wave, after: back, name: waving}",
    "{who: left, do: point, to: {object: screen, by: [0, 0, 0.2]}, with: waving}",
    "{who: right, do: reach, to: {body: chest, by: [0.14, 0.1, 0]}, inward: 0.7}",
    "{who: right, do: stay, duration: 0.5}",
    "{who: both, do: rest, duration: 1.2}",
)


@cache
def every():
    played = unjudged(script(*EVERY, frames=210), 0)
    return played, {step.title: step for step in played.script.plan.steps}


def test_every_gesture_is_in_the_script_and_a_person_can_make_it():
    played, steps = every()
    made = {title.split("(")[1].rstrip(")") for title in steps}
    assert made == {*GESTURES}
    assert max(step.to_s for step in steps.values()) < played.frames / played.fps
    assert judged(played) is None


def test_the_first_frames_are_still_and_paths_have_no_jumps():
    played, _ = every()
    first = [centres(played.script.pose(t)) for t in (0.0, 1 / 3, 2 / 3, 1.0)]
    assert np.ptp([c[1:] for c in first], axis=0).max() < 1e-9
    for hand in played.script.plan.hands:
        times = np.arange(0.0, played.frames / played.fps, 0.01)
        path = np.array([hand.at(t).position_m for t in times.tolist()])
        assert np.linalg.norm(np.diff(path, 2, axis=0), axis=1).max() < 40.0 * 0.01**2


def test_a_step_begins_when_it_is_told_to_and_takes_its_duration():
    _, steps = every()
    last = len(EVERY) - 1
    assert steps["motion.steps.24 (point)"].from_s == steps["motion.steps.23 (wave)"].from_s
    assert steps["motion.steps.11 (touch)"].from_s >= steps["motion.steps.5 (rest)"].to_s
    rest = steps[f"motion.steps.{last} (rest)"]
    assert rest.to_s - rest.from_s == pytest.approx(1.2)


def test_both_hands_make_a_gesture_each_and_may_begin_crossed():
    steps = (
        "{who: both, do: wave}",
        "{who: both, do: circle, plane: upright}",
        "{who: both, do: rest}",
    )
    played = unjudged(script(*steps), 1, {"start": "crossed"})
    assert judged(unjudged(script(*steps), 1)) is None
    assert [(s.title.split("(")[1][:-1], s.side) for s in played.script.plan.steps[:4]] == [
        ("wave", 0), ("wave", 1), ("circle", 0), ("circle", 1),
    ]  # fmt: skip
    first, begun = (played.script.pose(t) for t in (0.0, played.script.plan.steps[0].from_s))
    assert first.hands[0].position_m[1] > first.hands[1].position_m[1]
    assert begun.hands[0].position_m[1] < begun.hands[1].position_m[1]


def test_an_object_goes_with_the_hand_and_stands_where_it_was_put():
    played, steps = every()
    lifted, put = steps["motion.steps.1 (lift)"], steps["motion.steps.4 (put)"]
    before, up = (played.script.pose(t).objects["can"].position_m for t in (0.0, lifted.to_s))
    assert up - before == pytest.approx([0.0, 0.0, 0.1], abs=3e-3)  # tremor, sway of the torso
    after = played.script.pose(put.to_s).objects["can"].position_m
    top = played.scene.room.table_height_m
    assert after == pytest.approx([0.44, -0.2, top], abs=3e-3)
    assert "hold:can" in played.script.events(0.5 * (lifted.to_s + put.from_s))


def test_a_pointing_finger_is_in_line_with_its_target():
    played, steps = every()
    pose = played.script.pose(steps["motion.steps.24 (point)"].to_s - 0.01)
    way = pose.objects["screen"].position_m + np.array([0, 0, 0.2]) - pose.hands[1].position_m
    angle = math.acos(float(way @ pose.hands[1].rotation[:, 0]) / np.linalg.norm(way))
    assert math.degrees(angle) < 3.0


def test_a_hand_that_hides_is_behind_the_object_and_one_that_leaves_is_out_of_both_views():
    played, steps = every()
    left, right = stereo_rig(played.scene.rig).cameras
    hide = steps["motion.steps.19 (hide)"]
    times = np.linspace(hide.from_s, hide.to_s, 40).tolist()
    palms = [played.script.pose(t).hands[1].position_m for t in times]
    low = min(palms, key=lambda palm: palm[2])
    screen = played.script.pose(0.0).objects["screen"].position_m
    for camera in (left, right):
        u = project(camera, np.array([low, screen]))[:, 0]
        scale = camera.K[0, 0] / 0.8  # px for a metre where the screen stands
        assert abs(u[0] - u[1]) < 0.5 * 0.18 * scale
    leave = steps["motion.steps.21 (leave_view)"]
    middle = played.script.pose(0.5 * (leave.from_s + leave.to_s)).hands[1].position_m
    for camera in (left, right):
        u, _ = project(camera, middle)
        assert not 0 <= u < camera.width_px


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_drink_as_a_script_keeps_within_a_centimetre_of_drink(seed):
    """Head, hands and can over the whole episode, against the truth of the shipped scenario."""
    shipped = performance("drink", seed)
    scripted = perform(load_scenario(str(EXAMPLES / "drink_script.yaml")), seed)
    assert (scripted.frames, scripted.fps) == (shipped.frames, shipped.fps)
    moved = 0.0
    for t in np.arange(shipped.frames).astype(float) / shipped.fps:
        a, b = shipped.script.pose(t), scripted.script.pose(t)
        assert np.linalg.norm(centres(a) - centres(b), axis=1).max() <= 0.010
        assert np.linalg.norm(a.objects["can"].position_m - b.objects["can"].position_m) <= 0.010
        moved = max(moved, float(np.linalg.norm(centres(b) - centres(scripted.script.pose(0.0)))))
    assert moved > 0.3


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (
            ("{who: right, do: reach, to: {table: [0.3, 0.2]}, hold: 3}", "{who: right, do: rest, at: 2}"),
            "mine.yaml:13:7: motion.steps.1: overlaps in time: it begins at 2 s, but the right hand is busy with motion.steps.0 (reach) until",
        ),
        (
            ("{who: right, do: reach, to: {table: [0.5, 0.1, 0.3]}, duration: 0.1}",),
            "mine.yaml:12:7: motion.steps.0: duration: 0.1 s is too short for this way",
        ),
        (
            ("{who: right, do: reach, to: {table: [0.4, 0.9, 0.2]}}",),
            "mine.yaml:12:7: motion.steps.0: at",
        ),
        (
            ("{who: right, do: rest}", "{who: right, do: reach, to: {table: [0.9, 0.1, 0.1]}, hold: 2}"),
            "mine.yaml:13:7: motion.steps.1: at",
        ),
        (
            ("{who: left, do: reach, to: {object: screen, by: [0, 0, 0.1]}, hold: 1}",),
            "mine.yaml:12:7: motion.steps.0: at",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_played_names_the_step_and_its_place(steps, message):
    with pytest.raises(Unposable) as fault:
        perform(script(*steps), 0)
    assert message in str(fault.value)
