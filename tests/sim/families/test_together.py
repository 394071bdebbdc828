"""Hand and hand: clasps, claps, rolls and passes as the scenario catalogue describes them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.contact.contact import penetration
from sim.families.cyclic import Tempo
from sim.sequence import Simulation

NAMES = ("merge_and_hold", "clap", "roll_forearms", "pass_object")
SEEDS = range(4)

every = pytest.mark.parametrize("name", NAMES)


@cache
def performance(name, seed):
    return perform(load_scenario(name), seed)


def cues(name, seed):
    return {cue.name: cue for cue in performance(name, seed).script.plan.cues}


def palms(script, times):
    return np.array([[arm.palm_m for arm in script.body(t).arms] for t in times])


def gap_m(script, t_s):
    """Air between the hands [m], negative where they overlap."""
    body = script.body(t_s)
    obstacles = script.obstacles(body.torso, body.head)
    return -penetration(script.scene.anatomy, body.arms, body.curls, obstacles).hands_m


def speeds(path, dt_s):
    return np.linalg.norm(np.diff(path, axis=0), axis=-1) / dt_s


@every
def test_draws_can_be_posed_and_end_within_the_frames(name, seeds):
    for seed in seeds:
        played = performance(name, seed)
        assert played.redrawn == 0
        assert max(cue.to_s for cue in played.script.plan.cues) < played.frames / played.fps
        assert 40 <= played.frames <= 150


@every
def test_the_first_second_shows_two_still_hands_apart(name, seeds):
    for seed in seeds:
        first = palms(performance(name, seed).script, np.linspace(0.0, 1.0, 6).tolist())
        assert np.ptp(first, axis=0).max() < 1e-9
        assert np.linalg.norm(first[0, 0] - first[0, 1]) >= 0.25


@every
def test_hands_move_without_jumps(name, seeds):
    for seed in seeds:
        script = performance(name, seed).script
        times = np.arange(0.5, 15.0, 0.11)
        # Also where one piece of the motion ends and the next begins.
        joints = [t for cue in script.plan.cues for t in (cue.from_s, cue.to_s)]
        before = np.append(times, np.array(joints) - 5e-4)
        moved = palms(script, (before + 1e-3).tolist()) - palms(script, before.tolist())
        assert np.linalg.norm(moved, axis=-1).max() < 2.0e-3  # nobody here does 2 m/s


@every
def test_the_motion_is_the_same_at_any_frame_rate(name):
    slow = perform(load_scenario(name), 3, {"fps": 1, "frames": 16})
    fast = perform(load_scenario(name), 3, {"fps": 30, "frames": 480})
    for t in (2.0, 4.5, 7.25, 15.0):
        a, b = slow.script.pose(t), fast.script.pose(t)
        for side in (0, 1):
            np.testing.assert_array_equal(a.hands[side].position_m, b.hands[side].position_m)
            np.testing.assert_array_equal(a.hands[side].rotation, b.hands[side].rotation)
        np.testing.assert_array_equal(a.curls, b.curls)


def test_clasped_hands_touch_for_the_declared_time_and_are_apart_before_and_after(seeds):
    for seed in seeds:
        values = concrete(load_scenario("merge_and_hold"), seed)
        script, clasp = performance("merge_and_hold", seed).script, cues("merge_and_hold", seed)
        held = clasp["clasp"]
        assert held.to_s - held.from_s == pytest.approx(values["hold"], abs=1e-6)
        for t in np.linspace(held.from_s, held.to_s, 7).tolist():
            assert -0.005 <= gap_m(script, t) <= 0.002
        outer = ("right", "left").index(values["outer"])
        curls = script.body(held.from_s).curls
        assert (curls[outer, 1:4] > 0.15).all()  # round the fist, which is closed further
        assert (curls[1 - outer, 1:] > 0.6).all()
        for t in (1.0, clasp["part"].to_s):
            assert gap_m(script, t) > 0.1


def test_clasped_hands_are_one_blob_in_both_views_and_two_before_and_after():
    assert load_scenario("merge_and_hold").thesis == "Fig. 4.6, 4.7"
    for seed in (0, 1):
        played = performance("merge_and_hold", seed)
        clasp = cues("merge_and_hold", seed)
        held = clasp["clasp"]
        frames = [0, round(held.from_s * 3), round(clasp["part"].to_s * 3) + 1]
        with Simulation(played) as simulation:
            shots = [simulation.render(index) for index in frames]
        merged = [[view.merged[1, 2] for view in shot.truth.views] for shot in shots]
        assert merged == [[False, False], [True, True], [False, False]]
        for view in shots[1].truth.views:
            assert (view.visible_fractions[1:] > 0.2).all()


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
        values = concrete(load_scenario("clap"), seed)
        script = performance("clap", seed).script
        claps = [cue for cue in script.plan.cues if cue.name == "clap"]
        assert len(claps) == round(values["claps"])
        middles = [0.5 * (cue.from_s + cue.to_s) for cue in claps]
        np.testing.assert_allclose(np.diff(middles), 1.0 / values["frequency"], atol=1e-9)
        for t in middles:
            assert -0.005 <= gap_m(script, t) <= 0.002
        for t in (np.array(middles[:-1]) + 0.5 / values["frequency"]).tolist():
            assert gap_m(script, t) > 0.05


def test_claps_keep_below_their_top_speed_and_open_less_the_faster_they_are():
    wide = []
    for frequency in (0.5, 1.5, 3.0):
        chosen = {"frequency": frequency, "top_speed": 0.8, "opening": 0.3}
        script = perform(load_scenario("clap"), 1, chosen).script
        clapping = script.plan.cues[0]
        times = np.arange(clapping.from_s, clapping.to_s, 0.01).tolist()
        path = palms(script, times)
        assert speeds(path, 0.01).max() <= 0.85  # 0.8 and the turn of the hands
        wide.append(np.linalg.norm(path[:, 0] - path[:, 1], axis=1).max())
    assert wide[0] == pytest.approx(wide[1], abs=0.01)  # both may open all the way
    assert wide[2] < wide[1] - 0.1


def test_forearms_roll_round_each_other_without_touching(seeds):
    for seed in seeds:
        values = concrete(load_scenario("roll_forearms"), seed)
        script, roll = (
            performance("roll_forearms", seed).script,
            cues("roll_forearms", seed)["roll"],
        )
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


def test_a_thing_passes_from_one_hand_to_both_to_the_other(seeds):
    for seed in seeds:
        values = concrete(load_scenario("pass_object"), seed)
        script, said = performance("pass_object", seed).script, cues("pass_object", seed)
        giver = ("right", "left").index(values["giver"])
        names = ("right", "left")
        both = said["held_by:both"]
        assert both.to_s - both.from_s == pytest.approx(values["both_hold"])
        first, last = said[f"held_by:{names[giver]}"], said[f"held_by:{names[1 - giver]}"]
        assert first.to_s == both.from_s
        assert both.to_s == last.from_s
        assert [(h.side, h.from_s, h.to_s) for h in script.plan.holds] == [
            (giver, first.from_s, both.to_s),
            (1 - giver, both.to_s, last.to_s),
        ]
        for t in np.linspace(both.from_s, both.to_s - 1e-6, 4).tolist():
            pose = script.pose(t)
            axis = pose.objects["thing"].position_m[:2]
            for hand in pose.hands:
                assert np.linalg.norm(hand.position_m[:2] - axis) < 0.105
            assert gap_m(script, t) >= -0.005
            assert "held_by:both" in script.events(t)


def test_a_passed_thing_never_jumps_and_ends_upright_on_the_takers_side(seeds):
    for seed in seeds:
        script = performance("pass_object", seed).script
        outward = {"right": 1, "left": -1}[concrete(load_scenario("pass_object"), seed)["giver"]]
        holds = script.plan.holds
        times = [t for h in holds for t in (h.from_s, h.to_s)] + np.arange(2, 10, 0.2).tolist()
        for t in times:
            before, after = (script.pose(t + k * 5e-4).objects["thing"] for k in (-1, 1))
            assert np.linalg.norm(after.position_m - before.position_m) < 2e-3
        top = script.scene.room.table_height_m
        low = min(script.pose(t).objects["thing"].position_m[2] for t in times)
        assert low > top - 0.003
        end = script.pose(15.0).objects["thing"]
        assert end.position_m[2] == top
        assert end.position_m[1] * outward > 0.04
        assert end.rotation[2, 2] == pytest.approx(1.0)


@pytest.mark.parametrize("thing", ["cup", "box", "ball"])
def test_any_of_the_things_can_be_passed(thing):
    assert perform(load_scenario("pass_object"), 2, {"thing": thing}).redrawn == 0
