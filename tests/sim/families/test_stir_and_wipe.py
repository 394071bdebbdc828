"""Stirring in a cup and wiping with a cloth."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, performance, speeds

from scenarios.spec.draw import concrete
from scenarios.spec.names import load_scenario

SEEDS = range(200, 203)


def fine(script, side, from_s, to_s, dt_s=0.005):
    times = np.arange(from_s, to_s, dt_s)
    return np.array([script.body(t).arms[side].palm_m for t in times.tolist()])


@pytest.mark.long
@pytest.mark.parametrize("task", ["stir", "wipe"])
@pytest.mark.parametrize("hertz", [0.3, 1.4])
def test_rounds_are_as_wide_and_as_frequent_as_declared(task, hertz):
    played = performance(
        "stir_and_wipe",
        202,
        task=task,
        rounds=hertz,
        shape="circle",
        bout=9.0,
        bouts=1,
    )
    values = concrete(load_scenario("stir_and_wipe"), 202, {"task": task}, played.redrawn)
    side = HANDS.index(values["hand"])
    bout = next(cue for cue in played.script.plan.cues if cue.name == task)
    path = fine(played.script, side, bout.from_s + 0.8, bout.to_s - 0.8, 0.02)
    wide = values[f"{task}_size"]
    assert np.ptp(path[:, 0]) == pytest.approx(wide, abs=0.008)
    assert np.ptp(path[:, 1]) == pytest.approx(wide, abs=0.008)
    # One round of a circle is 2 pi r: the rate from the speed, within the draw of 7 %.
    rate = np.median(speeds(path, 0.02)) / (np.pi * wide)
    assert rate == pytest.approx(hertz, rel=0.12)


def test_the_range_of_rounds_is_that_of_the_catalogue():
    parameters = load_scenario("stir_and_wipe").parameters
    assert parameters["rounds"].range == (0.3, 1.4)
    assert parameters["stir_size"].range[0] == 0.03
    assert parameters["wipe_size"].range[1] == 0.15


def test_the_rod_goes_round_inside_the_cup(seed):
    played = performance("stir_and_wipe", seed, task="stir", other="holds_cup")
    cup = played.scene.room.objects[0]
    bout = next(cue for cue in played.script.plan.cues if cue.name == "stir")
    for t in np.linspace(bout.from_s, bout.to_s, 15).tolist():
        pose = played.script.pose(t)
        rod, place = pose.objects["rod"], pose.objects["cup"]
        ends = [rod.position_m + s * 0.115 * rod.rotation[:, 0] for s in (-1.0, 1.0)]
        low = min(ends, key=lambda end: end[2])
        assert np.hypot(*(low - place.position_m)[:2]) < 0.5 * 0.8 * cup.size_m[0]
        assert 0.0 < low[2] - place.position_m[2] < 0.05
        assert abs(rod.rotation[2, 0]) > 0.9  # upright


def test_the_cloth_lies_on_the_table_under_the_palm(seed):
    played = performance("stir_and_wipe", seed, task="wipe")
    (hold,) = (h for h in played.script.plan.holds if h.name == "cloth")
    top = played.scene.room.table_height_m
    for t in np.linspace(hold.from_s + 0.1, hold.to_s - 0.1, 9).tolist():
        pose = played.script.pose(t)
        cloth, palm = pose.objects["cloth"], pose.hands[hold.side]
        assert abs(cloth.position_m[2] - top) < 2e-3
        assert 0.0 < palm.position_m[2] - top < 0.05
        assert np.linalg.norm((palm.position_m - cloth.position_m)[:2]) < 0.03
