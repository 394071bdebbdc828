"""Measures and the judge: figures of motions that are known, and every reason to reject one."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.motion import measure as judge
from sim.motion.measure import TARGETS, measure, standing_objects
from sim.motion.motion import Hold, Performer
from sim.motion.planner import HandPlanner, raised, resting
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import hand_rotation
from sim.silhouettes.possible import surely_possible
from sim.specs import ObjectSpec, RoomSpec, SceneSpec
from sim.vectors import norm

TIMES = np.arange(0.0, 6.0, 1.0 / 3.0).tolist()
SCREEN = ObjectSpec("screen", "sheet", (0.02, 0.4, 0.4), (0.5, 0.5, 0.5), (0.36, -0.2))


def fault_of(performer, times_s):
    """The fault, which is the same where moments known to be possible are passed over."""
    fault = judge.fault_of(performer, times_s)
    if len(times_s):
        known = surely_possible(performer, times_s).tolist()
        assert judge.fault_of(performer, times_s, known) == fault
    return fault


@cache
def still_plan():
    return perform(load_scenario("cross"), 100, {"frames": 3}).script.plan


def performer(right, left=None, objects=(), holds=()):
    """A performer of these hand motions in an average room, without sway and tremor."""
    scene = replace(SceneSpec(), room=RoomSpec(objects=objects))
    plan = still_plan()
    still = replace(plan.sway, amplitudes_m=np.zeros_like(plan.sway.amplitudes_m))
    left = left or HandPlanner(resting(scene, 1, 0.34, 0.22, 0.3, 0.1)).path()
    return Performer(
        scene, replace(plan, hands=(right, left), sway=still, tremor=(still, still), holds=holds)
    )


def rest(side=0):
    return resting(SceneSpec(), side, 0.34, 0.22, 0.3, 0.1)


def stroke_to(state, peak_mps=0.5, least_s=0.2):
    hand = HandPlanner(rest())
    hand.until(1.0)
    hand.move(state, peak_mps, least_s=least_s)
    return hand.path()


def at(x, y, z, side=0, inward=0.3):
    return raised(side, [x, y, z], inward, 0.0, 0.6)


@dataclass(frozen=True)
class Swing:
    """A hand on a sine along y, turning about nothing."""

    amplitude_m: float
    period_s: float

    def at(self, t_s):
        y = -0.25 + self.amplitude_m * math.sin(2 * math.pi * t_s / self.period_s)
        return at(0.38, y, 0.95)


def test_a_plain_motion_has_no_fault():
    assert fault_of(performer(stroke_to(at(0.40, -0.15, 0.95))), TIMES) is None
    assert fault_of(performer(stroke_to(at(0.40, -0.15, 0.95))), []) is None


@pytest.mark.long
def test_hands_told_to_be_in_one_place_are_parted_before_they_are_judged():
    left = HandPlanner(rest(1))
    left.until(1.0)
    left.move(at(0.36, 0.0, 0.95, side=1), 0.5)
    right = stroke_to(at(0.36, 0.0, 0.95))
    together = performer(right, left.path())
    assert fault_of(together, TIMES) is None
    figures = measure(together, TIMES)
    assert figures.deepest_m <= 0.002
    assert figures.hands_gap_m > -0.002
    assert figures.hands_gap_m < 0.005


def test_a_hand_through_a_screen_is_a_fault_unless_the_screen_is_held():
    through = stroke_to(at(0.38, -0.2, 0.9))
    fault = fault_of(performer(through, objects=(SCREEN,)), TIMES)
    assert fault is not None
    assert "mm in the screen" in fault
    assert "allowed 5 mm" in fault
    held = performer(through, objects=(SCREEN,), holds=(Hold("screen", 0, 3.0, 4.0),))
    assert standing_objects(held) == ()
    beside = replace(SCREEN, position_xy_m=(0.60, -0.2))
    assert fault_of(performer(through, objects=(beside,)), TIMES) is None


@pytest.mark.parametrize("kind", ["post", "block", "book", "can"])
def test_things_stand_where_they_are_drawn(kind):
    size, at_xy = (0.06, 0.06, 0.3), (0.40, -0.15)
    thing = ObjectSpec("thing", kind, size, (0.5, 0.5, 0.5), at_xy)
    on_it = performer(stroke_to(at(0.40, -0.15, 0.85)), objects=(thing,))
    assert "thing" in str(fault_of(on_it, TIMES))
    over_it = performer(
        stroke_to(at(0.40, -0.15, 1.13)),
        objects=(replace(thing, position_xy_m=(0.50, -0.15)),),
    )
    assert fault_of(over_it, TIMES) is None


def test_a_target_out_of_reach_is_a_fault_with_its_size():
    fault = fault_of(performer(stroke_to(at(1.15, -0.25, 0.95))), TIMES)
    assert fault is not None
    assert "the right palm stays" in fault
    assert "mm short of its target" in fault
    figures = measure(performer(stroke_to(at(1.15, -0.25, 0.95))), TIMES)
    assert figures.short_m > 0.05
    assert figures.stretch == pytest.approx(0.985, abs=1e-6)


def test_an_absurd_speed_is_a_fault_even_between_two_frames():
    fast = stroke_to(at(0.40, 0.25, 1.1), peak_mps=12.0, least_s=0.01)
    assert "m/s (at most 6 m/s)" in str(fault_of(performer(fast), TIMES))


def test_an_arm_forced_behind_the_back_is_a_fault():
    """Straight back from the shoulder, fingers back: however the elbow turns."""
    turned = hand_rotation(0, math.pi, 0.0, 0.0)
    behind = HandState(np.array([-0.60, -0.35, 1.0]), quaternion_of(turned), np.zeros(5))
    fault = fault_of(performer(HandPlanner(behind).path()), TIMES)
    assert "the right upper arm goes backward by 8" in str(fault)


def test_what_is_left_inside_is_a_fault_that_names_both_parts():
    """A head so large that no arm gets out of it."""
    plain = performer(HandPlanner(rest()).path())
    size = {f"head_{name}_m": 3.0 for name in ("depth", "breadth", "height")}
    giant = replace(plain.scene, anatomy=replace(plain.scene.anatomy, **size))
    fault = fault_of(replace(plain, scene=giant), TIMES)
    assert fault is not None
    assert fault.startswith("at 0.00 s the ")
    assert "mm in the head (allowed 5 mm)" in fault


def test_speeds_of_a_sine_are_those_of_its_formula():
    amplitude, period = 0.12, 1.7
    times = np.arange(0.0, 20.0, 0.1037).tolist()
    figures = measure(performer(Swing(amplitude, period)), times)
    speeds = figures.speeds["right hand"]
    top = 2 * math.pi * amplitude / period
    assert speeds.top_mps == pytest.approx(top, rel=0.01)
    assert speeds.median_mps == pytest.approx(top / math.sqrt(2), rel=0.03)
    # A chord over 1/3 s: 2 A sin(pi dt / T) |cos|, its median at cos(45 degrees).
    chord = 2 * amplitude * math.sin(math.pi / 3 / period)
    assert speeds.step_m[0] == pytest.approx(chord / math.sqrt(2), rel=0.03)
    assert speeds.step_m[2] == pytest.approx(chord, rel=0.01)
    missed = 4 * amplitude * math.sin(math.pi / 3 / period) ** 2
    assert speeds.missed_m[0] == pytest.approx(missed / math.sqrt(2), rel=0.03)
    assert set(figures.speeds) == {*TARGETS, "hands"}
    assert figures.speeds["hands"].top_mps == speeds.top_mps
    assert figures.speeds["left hand"].top_mps < 1e-6


def test_largest_angles_are_those_of_the_poses():
    script = performer(stroke_to(at(0.25, -0.1, 1.0)))
    figures = measure(script, TIMES)
    bends = []
    for t in TIMES:
        for arm in script.body(t).arms:
            upper, fore = arm.elbow_m - arm.shoulder_m, arm.wrist_m - arm.elbow_m
            bends.append(math.acos(upper @ fore / norm(upper) / norm(fore)))
    assert figures.elbow_flexion_rad == pytest.approx(max(bends), abs=1e-9)


def test_measuring_needs_a_moment():
    with pytest.raises(ValueError, match="at least one moment"):
        measure(performer(stroke_to(at(0.4, -0.15, 0.95))), [])
