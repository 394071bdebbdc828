"""Every scenario of the catalogue could be done by a person, and the survey says what it finds."""

from __future__ import annotations

import io
import math
from functools import cache

import pytest
from rich.console import Console

from scenarios.catalogue.survey import frame_times, survey_scenario
from scenarios.catalogue.survey_table import RECORDED, survey_table
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario, scenario_names
from sim.motion.measure import ALLOWED_SHORT_M, fault_of
from sim.motion.motion import performer_of
from sim.person.kinematics import (
    MAX_ADDUCTION_RAD,
    MAX_ELBOW_FLEXION_RAD,
    MAX_EXTENSION_RAD,
    MAX_STRETCH,
    MAX_WRIST_BEND_RAD,
)


@cache
def surveyed(name, seeds=(0,)):
    return survey_scenario(load_scenario(name), seeds)


def surveyed_once_a_second(name, seed):
    """The whole film, at a third of its moments: those between are posed in tests/sim/families."""
    scenario = load_scenario(name)
    return survey_scenario(scenario, (seed,), {"fps": 1, "frames": scenario.frames // 3})


# Every third by default; the others, and a second seed, with `-m long`.
CASES = [
    pytest.param(name, seed, marks=() if seed == i % 3 == 0 else (pytest.mark.long,))
    for i, name in enumerate(scenario_names())
    for seed in (0, 1)
]


@pytest.mark.sample(2)
@pytest.mark.parametrize(("name", "seed"), CASES)
def test_a_person_could_do_every_scenario(name, seed):
    found = surveyed_once_a_second(name, seed)
    assert found.deepest_m <= 0.005, found.deepest
    assert found.short_m <= ALLOWED_SHORT_M
    assert found.faults == ()
    for seed in found.seeds:
        measures = seed.measures
        assert measures.wrist_bend_rad <= MAX_WRIST_BEND_RAD + math.radians(3.0)
        assert measures.elbow_flexion_rad <= MAX_ELBOW_FLEXION_RAD + math.radians(0.5)
        assert measures.extension_rad <= MAX_EXTENSION_RAD + math.radians(0.5)
        assert measures.adduction_rad <= MAX_ADDUCTION_RAD + math.radians(0.5)
        assert measures.stretch <= MAX_STRETCH + 1e-6
        assert all(speeds.top_mps <= 6.0 for speeds in measures.speeds.values())


def test_what_was_drawn_again_is_counted():
    found = surveyed("cross", (0, 1))
    redrawn = [perform(load_scenario("cross"), seed).redrawn for seed in range(2)]
    assert [seed.redrawn for seed in found.seeds] == redrawn
    assert found.redrawn_share == sum(redrawn) / (sum(redrawn) + 2)


@pytest.mark.long
def test_calm_motion_is_slower_than_natural_motion():
    calm, natural = surveyed("calm_table").hands, surveyed("natural_table").hands
    assert calm.top_mps < 0.3 < natural.top_mps
    assert calm.step_m[2] < natural.step_m[2]
    assert calm.missed_m[1] < natural.missed_m[1] < RECORDED.missed_m[1] * 1.5


def test_overrides_reach_the_motion():
    slow = survey_scenario(load_scenario("natural_table"), [0], {"frames": 30})
    assert len(frame_times(perform(load_scenario("natural_table"), 0, {"frames": 30}))) == 30
    assert len(slow.seeds) == 1


def test_seeds_must_be_given():
    with pytest.raises(ValueError, match="at least one seed"):
        survey_scenario(load_scenario("cross"), [])


def test_the_table_names_all_scenarios_and_the_recorded_figures():
    names = ("cross", "calm_table")
    screen = Console(file=io.StringIO(), width=200)
    screen.print(survey_table([surveyed(name) for name in names]))
    text = screen.file.getvalue()
    assert all(name in text for name in names)
    assert "0.20/1.50/3.9" in text
    assert "58/292/563" in text
    assert "97/421" in text


def test_what_survives_drawing_has_no_fault():
    performance = perform(load_scenario("bounce"), 1)
    assert fault_of(performer_of(performance.script), frame_times(performance)) is None
