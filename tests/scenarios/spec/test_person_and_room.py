"""Person, habits, room and nuisances as parameters: what values of them look like."""

import math
from functools import cache

import cv2
import numpy as np
import pytest

from scenarios.spec.draw import concrete, in_si, perform, scene_of
from scenarios.spec.names import load_scenario, scenario_names
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.person_and_room import (
    NEAR_SKIN,
    PARAMETERS,
    appearance_of,
    extras_of,
    hair_rgb,
    room_of,
    skin_rgb,
)
from sim.camera.colour import light_rgb
from sim.families.registry import FAMILIES
from sim.randomness import generator
from sim.scene.world import build

SEEDS = range(100, 130)
SCENARIO = load_scenario("cross")
CHOICES = [
    (name, word)
    for name, parameter in PARAMETERS.items()
    if isinstance(parameter, Choice)
    for word in parameter.choices
]


def values(seed=100, **overrides):
    return in_si(SCENARIO, concrete(SCENARIO, seed, overrides))


def things_of(name):
    """Objects of a scenario's own gesture."""
    scenario = load_scenario(name)
    return FAMILIES[scenario.motion.kind].objects(in_si(scenario, concrete(scenario, 100)))


@cache
def performance(seed, *overrides):
    return perform(SCENARIO, seed, {"frames": 24, **dict(overrides)})  # eight seconds


def lab(rgb):
    return cv2.cvtColor(np.array([[rgb]], np.float32), cv2.COLOR_RGB2LAB)[0, 0]


@pytest.mark.parametrize("ita_deg", range(-50, 61, 10))
def test_a_skin_colour_has_the_typology_angle_asked_for(ita_deg):
    L, _, b = lab(skin_rgb(math.radians(ita_deg)))
    assert math.degrees(math.atan2(L - 50, b)) == pytest.approx(ita_deg, abs=1.0)


def test_all_six_classes_of_skin_are_visibly_apart():
    """Chardon et al. 1991: very light > 55 > light > 41 > intermediate > 28 > tan > 10 > brown >
    -30 > dark; 2.3 is a just noticeable difference."""
    tones = [lab(skin_rgb(math.radians(ita))) for ita in (58, 48, 34, 19, -10, -40)]
    assert np.linalg.norm(np.diff(tones, axis=0), axis=1).min() > 3 * 2.3
    assert (np.diff([L for L, _, _ in tones]) < 0).all()


def test_skin_is_where_a_detector_may_look_for_it():
    """Hue 8-31 degrees and a saturation that is neither grey nor paint, at every tone."""
    for ita in range(-50, 61, 5):
        rgb = np.array([[skin_rgb(math.radians(ita))]], np.float32)
        hue, saturation, value = cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV)[0, 0]
        assert 8 < hue < 31
        assert 0.15 < saturation < 0.65
        assert value > 0.2


def test_hair_is_never_as_colourful_as_skin():
    values_ = []
    for tone in np.linspace(0, 1, 41):
        red, green, blue = rgb = hair_rgb(float(tone))
        assert red >= green >= blue
        assert (red - blue) / red < 0.36
        values_.append(max(rgb))
    # Black, brown, blond get lighter; grey is a bit darker than blond.
    assert values_[0] < 0.06
    assert values_[34] == max(values_) > 0.6


def test_words_and_numbers_become_the_look():
    given = values(
        sleeves="rolled", hair="long", beard="yes", glasses="no", shirt_pattern="checks",
        shirt_hue=120.0, shirt_saturation=0.5, shirt_value=0.8,
    )  # fmt: skip
    look = appearance_of(given)
    assert (look.sleeves, look.hair, look.beard, look.glasses) == ("rolled", "long", True, False)
    assert look.shirt_pattern == "checks"
    np.testing.assert_allclose(look.shirt_rgb, (0.4, 0.8, 0.4), atol=1e-9)
    room = room_of(
        values(table_hue=0.0, table_saturation=1.0, table_value=0.6, table_surface="cloth",
               light_temperature=3000.0, light_azimuth=30.0), ()
    )  # fmt: skip
    np.testing.assert_allclose(room.table_rgb, (0.6, 0.0, 0.0), atol=1e-9)
    assert room.table_surface == "cloth"
    assert room.light_rgb == light_rgb(3000.0)
    assert room.light_azimuth_rad == pytest.approx(math.radians(30))


@pytest.mark.parametrize("what", ["wall", "table", "shirt", "all"])
def test_near_skin_colours_what_it_names_and_nothing_else(what):
    plain, near = values(), values(near_skin=what)
    for thing in NEAR_SKIN:

        def colour(given, thing=thing):
            if thing == "shirt":
                return appearance_of(given).shirt_rgb
            return getattr(room_of(given, ()), f"{thing}_rgb")

        changed = colour(near) != colour(plain)
        assert changed == (what in (thing, "all"))
        if changed:
            assert colour(near) == NEAR_SKIN[thing]


def test_what_is_near_skin_is_near_skin_and_nominally_nothing_is():
    skins = np.array([lab(skin_rgb(math.radians(ita)))[1:] for ita in range(20, 50, 5)])
    for rgb in NEAR_SKIN.values():
        assert np.linalg.norm(skins - lab(rgb)[1:], axis=1).min() < 8.0
    for seed in SEEDS:
        given = values(seed)
        room = room_of(given, ())
        for rgb in (room.wall_rgb, room.table_rgb, appearance_of(given).shirt_rgb):
            assert np.linalg.norm(skins - lab(rgb)[1:], axis=1).min() > 12.0


def test_nominal_draws_vary_what_harms_nobody_and_leave_the_nuisances_out():
    drawn = [values(seed) for seed in SEEDS]
    for name, usual in (
        ("sleeves", "long"), ("near_skin", "none"), ("shadow", "none"), ("mover", "none"),
        ("background_change", "none"), ("start", "apart"), ("light_temperature", 6500.0),
    ):  # fmt: skip
        assert {d[name] for d in drawn} == {usual}
    for name in ("hair", "beard", "glasses", "shirt_pattern", "table_surface"):
        assert len({d[name] for d in drawn}) > 1
    assert sum(d["glasses"] == "no" for d in drawn) > len(drawn) / 2


@pytest.mark.sample(5)
@pytest.mark.parametrize(("name", "word"), CHOICES)
def test_every_choice_builds_and_its_things_are_there(name, word):
    given = values(**{name: word})
    extras = extras_of(given, lambda stream: generator(100, stream), 16.0)
    scene = scene_of(SCENARIO, given, extras)
    world = build(scene)
    names = {thing.name for thing in extras.objects}
    assert bool(names) == (name in ("shadow", "mover", "background_change") and word != "none")
    assert {f"object:{thing}" for thing in names} <= set(world.bodies)
    assert set(extras.learnt) == names


def test_a_nuisance_leaves_the_scenarios_draws_alone():
    plain = performance(101)
    for change in (("mover", "arm"), ("shadow", "fast"), ("sleeves", "short")):
        other = performance(101, change)
        for t in (0.0, 3.0, 7.5):
            for a, b in zip(plain.script.pose(t).hands, other.script.pose(t).hands, strict=True):
                np.testing.assert_array_equal(a.position_m, b.position_m)


@pytest.mark.long
def test_the_other_arm_never_touches_the_person():
    """Axes of the arms: two forearms' or a hand's thickness apart at least."""
    for name in ("calm_table", "lean_and_reach", "natural_table"):
        for seed in (100, 101):
            played = perform(load_scenario(name), seed, {"mover": "arm"})
            for t in np.arange(0.0, played.frames / played.fps, 0.5).tolist():
                pose = played.script.pose(t)
                other = pose.objects["other_arm"]
                along = np.linspace(-0.31, 0.31, 20)[:, None]
                bone = other.position_m + along * other.rotation[:, 0] + [0.0, 0.0, 0.0375]
                for hand, fore in zip(pose.hands, pose.forearms, strict=True):
                    ends = ((hand, -0.07, 0.10), (fore, 0.0, 0.25))
                    own = np.concatenate(
                        [
                            part.position_m + np.linspace(a, b, 8)[:, None] * part.rotation[:, 0]
                            for part, a, b in ends
                        ]
                    )
                    gap = np.linalg.norm(bone[:, None] - own[None], axis=2).min()
                    assert gap > 0.08


@pytest.mark.parametrize("name", [n for n in scenario_names() if things_of(n)])
def test_every_scenario_with_things_bears_things_that_move_by_themselves(name):
    scenario = load_scenario(name)
    asked = {"mover": "balloon", "shadow": "fast", "background_change": "box", "frames": 4}
    own = len(perform(scenario, 104, {"frames": 4}).scene.room.objects)
    crowded = perform(scenario, 104, asked)
    added = [thing.name for thing in crowded.scene.room.objects[own:]]
    assert len(added) >= 3
    assert set(added) & set(crowded.script.pose(0.5).objects)


def test_skin_gets_darker_with_the_typology_angle_and_stays_skin():
    tones = np.array([skin_rgb(math.radians(a)) for a in range(-50, 61, 10)])
    assert (np.diff(tones.sum(axis=1)) > 0).all()
    assert ((tones > 0.02) & (tones < 1.0)).all()
    assert (tones[:, 0] > tones[:, 1]).all()
    assert (tones[:, 1] > tones[:, 2]).all()
