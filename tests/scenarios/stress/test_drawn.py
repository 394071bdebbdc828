"""What a case leaves to its seed, and that setting it to what it was changes nothing."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from scenarios.play.fast import play_fast
from scenarios.play.job import System
from scenarios.spec.draw import concrete
from scenarios.spec.names import load_scenario
from scenarios.spec.scenario import in_varied_surroundings
from scenarios.spec.standard import STANDARD
from scenarios.stress.case import Case
from scenarios.stress.drawn import drawn_part, drawn_space, drawn_values
from scenarios.stress.families import find_family
from scenarios.stress.play_trial import result_of
from scenarios.stress.space import Space

SHORT = {"frames": 6.0}


@pytest.mark.parametrize(("family", "standard"), [("bounce", 0), ("recorded", 4)])
def test_what_the_family_does_not_vary_is_drawn(family, standard):
    """All standard parameters but those that vary or are set; never a file."""
    space = Space.of(find_family(family), also=["beard"], fixed={"stature": 1.7})
    names = drawn_space(space).names
    assert set(names) < set(STANDARD)
    assert len(names) == len(STANDARD) - standard - 2
    assert not {"beard", "stature"} & set(names)


@pytest.mark.parametrize(("family", "seed"), [("bounce", 3), ("recorded", 4)])
def test_an_episode_with_all_drawn_values_set_is_the_same_to_the_bit(family, seed):
    """No random stream moves when a value is set to what was drawn."""
    space = Space.of(find_family(family), fixed=SHORT)
    case = Case(family, space.nominal(), seed)
    whole = case.with_values(drawn_values(space, case))
    system = System("thesis", "thesis")
    episodes = [play_fast(c.job(system)) for c in (case, whole)]
    first, second = (result_of("same", episode).to_json() for episode in episodes)
    assert first == second
    for one, other in zip(*(episode.frames for episode in episodes), strict=True):
        np.testing.assert_equal(*(asdict(replace(frame, stage_s={})) for frame in (one, other)))


def test_in_varied_surroundings_all_must_be_set_for_the_rig_to_stay():
    """The rig is drawn until it sees the person: a value of it that is set moves the others."""
    scenario = in_varied_surroundings(load_scenario("calm_table"), "rooms")
    moved = 0
    for seed in range(20):
        values = concrete(scenario, seed)
        assert concrete(scenario, seed, values) == values
        moved += concrete(scenario, seed, {"focal": values["focal"]}) != values
    assert moved > 0


def test_a_value_that_a_case_sets_counts_as_drawn():
    space = Space.of(find_family("bounce"))
    case = Case("bounce", {**space.nominal(), "beard": "yes"}, 1)
    assert drawn_values(space, case)["beard"] == "yes"


@pytest.mark.parametrize(
    ("name", "value", "part"),
    [
        ("stature", 1.67, "low"),
        ("stature", 1.72, "middle"),
        ("stature", 1.75, "high"),
        ("beard", "yes", "yes"),
    ],
)
def test_parts_are_thirds_of_what_is_drawn(name, value, part):
    """Of the nominal distribution (mean 1.71 m, sd 0.06 m), not of the range 1.52 to 1.90 m."""
    assert drawn_part(drawn_space(Space.of(find_family("bounce"))).axis(name), value) == part
