"""The conformance check of motions: ours conform, and each fault is a line."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

from pathlib import Path

import pytest

from pjpdaf.plugins.loading import NoSuchPlugIn
from scenarios.catalogue.motion_check import check_motion
from scenarios.spec.motion.plugged import TRUSTED_VARIABLE

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture
def plugged(monkeypatch):
    monkeypatch.setenv(TRUSTED_VARIABLE, "")  # `check_motion` adds to it
    monkeypatch.syspath_prepend(str(EXAMPLES))
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))


def check(name):
    return check_motion(f"faulty_motions:{name}", 30.0)


def test_a_good_motion_and_the_example_conform(plugged):
    assert check("good") == ()
    assert check_motion("own_motion:knock", 30.0) == ()


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("no_motion", "its factory must return an OwnMotion (sim.families.plugged), returns int."),
        ("raises", "cannot be built: KeyError: 'nothing' (faulty_motions.py:"),
        ("ends", "cannot be built: SystemExit: 3 (faulty_motions.py:"),
        ("without_unit", "the parameter 'speed': unit: Field required."),
        ("without_meaning", "the parameter 'speed': needs a meaning."),
        ("reversed_range", "the parameter 'speed': range: range is reversed: 1 is greater than 0.2."),
        ("standard_name", "The motion 'faulty_motions:standard_name': faulty_motions:standard_name declares stature, the name of a standard parameter"),
        ("plan_raises", "plan: raises ZeroDivisionError: speed (faulty_motions.py:"),
        ("at_an_end", "raises ValueError: too fast (faulty_motions.py:"),
        ("no_plan", "plan: must return a MotionPlan (stage.plan makes it), returns NoneType."),
        ("moves_at_once", "seed 0: hands must be still for the first 1.1 s (stage.start_s)"),
        ("random", "plan: differs when planned again with the same seed; draw from stage.streams only"),
        ("backwards", "seed 0: cue x: must end after it begins, 3.0 to 2.0"),
        ("jumps", "seed 0: the right hand: jumps by 200 mm at 2.00 s; join moves"),
        ("not_finite", "seed 0: the right hand: has NaN or infinite values at 2.00 s"),
        ("curled_twice", "seed 0: the right hand: curls must be from 0 to 1, are"),
        ("too_far", "pose: too_far seed 0: none of 20 draws can be posed; the first: at "),
    ],
)  # fmt: skip
def test_each_fault_is_a_line(name, fault, plugged):
    faults = check(name)
    assert any(fault in line for line in faults), faults
    assert all("\n" not in line for line in faults)


def test_a_name_that_is_not_there(plugged):
    with pytest.raises(NoSuchPlugIn, match="Did you mean 'good'"):
        check("god")
