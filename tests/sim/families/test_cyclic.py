"""Claps, and forearms that roll round each other."""

from __future__ import annotations

import numpy as np
import pytest
from performances import cue, drawn, gap_m, palms, performance, speeds

from sim.families.cyclic import Tempo

SEEDS = range(4)


def test_a_tempo_counts_whole_cycles_and_starts_and_ends_with_no_speed_and_no_acceleration():
    for frequency, cycles in ((0.5, 2), (1.8, 7), (3.0, 30)):
        tempo = Tempo(1.0, frequency, cycles)
        assert tempo.phase(1.0) == 0.0
        assert tempo.phase(tempo.end_s) == cycles
        middle = 0.5 * (tempo.start_s + tempo.end_s)
        rate = (tempo.phase(middle + 1e-4) - tempo.phase(middle - 1e-4)) / 2e-4
        assert rate == pytest.approx(frequency)
        for t in (tempo.start_s, tempo.end_s):
            step = 1e-3 / frequency
            a, b, c = (tempo.phase(t + k * step) for k in (-1, 0, 1))
            assert abs(a - 2 * b + c) / step**2 < 1e-4 * frequency**2
        # Twice differentiable all the way: the second difference has no steps.
        phase = np.array([tempo.phase(t) for t in np.arange(0.5, tempo.end_s + 0.5, 0.002)])
        second = np.diff(phase, 2) / 0.002**2
        assert np.abs(np.diff(second)).max() < 0.05 * frequency**2


def test_palms_meet_at_the_declared_tempo_as_often_as_declared(seeds):
    for seed in seeds:
        values = drawn("clap", seed)
        script = performance("clap", seed).script
        claps = [cue for cue in script.plan.cues if cue.name == "clap"]
        assert len(claps) == round(values["claps"])
        middles = [0.5 * (cue.from_s + cue.to_s) for cue in claps]
        np.testing.assert_allclose(np.diff(middles), 1.0 / values["frequency"], atol=1e-9)
        for t in middles:
            assert -0.005 <= gap_m(script, t) <= 0.002
        for t in (np.array(middles[:-1]) + 0.5 / values["frequency"]).tolist():
            assert gap_m(script, t) > 0.05


@pytest.mark.long
def test_claps_keep_below_their_top_speed_and_open_less_the_faster_they_are():
    wide = []
    for frequency in (0.5, 1.5, 3.0):
        chosen = {"frequency": frequency, "top_speed": 0.8, "opening": 0.3}
        script = performance("clap", 1, **chosen).script
        clapping = script.plan.cues[0]
        times = np.arange(clapping.from_s, clapping.to_s, 0.01).tolist()
        path = palms(script, times)
        assert speeds(path, 0.01).max() <= 0.85  # 0.8 and the turn of the hands
        wide.append(np.linalg.norm(path[:, 0] - path[:, 1], axis=1).max())
    assert wide[0] == pytest.approx(wide[1], abs=0.01)  # both may open all the way
    assert wide[2] < wide[1] - 0.1


def test_forearms_roll_round_each_other_without_touching(seeds):
    for seed in seeds:
        values = drawn("roll_forearms", seed)
        played = performance("roll_forearms", seed)
        script, roll = played.script, cue(played, "roll")
        times = np.arange(roll.from_s, roll.to_s, 0.03).tolist()
        path = palms(script, times)
        between = (path[:, 0] - path[:, 1])[:, [0, 2]]
        assert np.linalg.norm(between, axis=1) == pytest.approx(2 * values["radius"], abs=0.008)
        turned = np.unwrap(np.arctan2(between[:, 0], between[:, 1]))
        turns = abs(turned[-1] - turned[0]) / (2 * np.pi)
        assert turns == pytest.approx(round(values["turns"]), abs=0.1)
        steady = np.abs(np.diff(turned)) / (2 * np.pi * 0.03)
        assert np.median(steady) == pytest.approx(values["frequency"], rel=0.1)
        assert min(gap_m(script, t) for t in times) > 0.0
