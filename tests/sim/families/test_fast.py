"""Fast motion: speeds, brakes, reversals, the thesis's fast end, and one motion at all rates."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pjpdaf.targets import LEFT_HAND, RIGHT_HAND
from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.camera.render import StereoRenderer
from sim.labels import view_truth
from sim.motion.measure import fault_of
from sim.scene.world import build
from sim.vectors import norm

NAMES = ("stop_and_reverse", "fast_finish")
SEEDS = range(200, 203)
HANDS = ("right", "left")
DT_S = 0.002

every = pytest.mark.parametrize("name", NAMES)


@cache
def performance(name, seed, **overrides):
    return perform(load_scenario(name), seed, overrides)


def cues(played, name):
    return [cue for cue in played.script.plan.cues if cue.name.startswith(name)]


def told(played, side, from_s, to_s):
    """Times (n,) and the places (n, 3) that a hand is told to be at."""
    times = np.arange(from_s, to_s, DT_S)
    hand = played.script.plan.hands[side]
    return times, np.array([hand.at(t).position_m for t in times.tolist()])


def speeds(path, dt_s=DT_S):
    return np.linalg.norm(np.diff(path, axis=0), axis=-1) / dt_s


@every
@pytest.mark.parametrize("count", [3, pytest.param(10, marks=pytest.mark.long)])
def test_nearly_every_seed_is_posable_at_once(name, count):
    scenario = load_scenario(name)
    assert sum(perform(scenario, seed).redrawn > 0 for seed in range(200, 200 + count)) <= 1


@every
def test_the_motion_is_possible_between_frames_as_well(name):
    played = performance(name, SEEDS[0])
    times = np.arange(0.0, played.frames / played.fps, 0.1) + 0.031
    assert fault_of(played.script, times.tolist()) is None


@every
def test_hands_start_still_and_apart_and_move_without_jumps(name, seeds):
    for seed in seeds:
        played = performance(name, seed)
        first = [[a.palm_m for a in played.script.body(t).arms] for t in (0.0, 0.5, 1.0)]
        assert np.ptp(first, axis=0).max() < 1e-9
        assert norm(first[0][0] - first[0][1]) >= 0.25
        end_s = played.frames / played.fps
        for side in (0, 1):
            _, path = told(played, side, 0.0, end_s)
            top = speeds(path).max()
            assert np.abs(np.diff(path, 2, axis=0)).max() < DT_S**2 * 80.0  # m/s2
            for t in np.arange(0.5, end_s, 0.37).tolist():
                now, then = (played.script.body(at).arms[side].palm_m for at in (t, t + 1e-3))
                # Hands that touch are moved apart a little faster than they are told.
                assert norm(then - now) <= 1.2e-3 * top + 2e-4


@every
def test_the_motion_does_not_depend_on_the_frame_rate(name):
    slow = performance(name, SEEDS[0], fps=2, frames=24).script
    fast = performance(name, SEEDS[0], fps=24, frames=288).script
    for t in (0.0, 4.25, 2.125, 7.5):
        for a, b in zip(slow.pose(t).hands, fast.pose(t).hands, strict=True):
            np.testing.assert_array_equal(a.position_m, b.position_m)
            np.testing.assert_array_equal(a.rotation, b.rotation)


def test_strokes_go_from_slow_to_fast_and_stop_within_the_brake(seeds):
    peaks = []
    for seed in seeds:
        played = performance("stop_and_reverse", seed)
        brake = concrete(load_scenario("stop_and_reverse"), seed)["brake"]
        for cue in cues(played, "stop:"):
            side = HANDS.index(cue.name.partition(":")[2])
            times, path = told(played, side, cue.from_s, cue.to_s)
            speed = speeds(path)
            peaks.append(speed.max())
            # From 9/10 of the peak to nothing; a whole stroke takes a third of its time for that.
            fading = cue.to_s - times[:-1][speed > 0.9 * speed.max()][-1]
            assert fading <= 1.25 * brake + 0.04
            assert speed[-1] < 0.05 * speed.max()
    assert 0.28 <= min(peaks) < 0.45
    assert 1.1 < max(peaks) <= 1.55


def test_reversals_turn_back_from_mid_stroke_to_where_they_began(seeds):
    for seed in seeds:
        played = performance("stop_and_reverse", seed)
        found = cues(played, "reverse:")
        assert len(found) >= 6
        for cue in found:
            side = HANDS.index(cue.name.partition(":")[2])
            _, path = told(played, side, cue.from_s, cue.to_s)
            away = np.linalg.norm(path - path[0], axis=1)
            turn = int(away.argmax())
            assert away[-1] < 0.005
            assert away[turn] > 0.05
            # It turns at once: it is slow there for less than a fifth of a second.
            slow = speeds(path) < 0.1 * speeds(path).max()
            assert slow[turn - 60 : turn + 60].sum() * DT_S < 0.2
            out, back = path[turn] - path[0], path[-1] - path[turn]
            assert float(out @ back) < -0.99 * norm(out) * norm(back)


def test_both_hands_stop_and_reverse_in_every_seed(seeds):
    for seed in seeds:
        names = {cue.name for cue in performance("stop_and_reverse", seed).script.plan.cues}
        assert names >= {f"{kind}:{hand}" for kind in ("stop", "reverse") for hand in HANDS}


def test_fast_finish_merges_and_then_grows_from_0_8_to_2_5_mps_up_to_the_end(seeds):
    for seed in seeds:
        played = performance("fast_finish", seed)
        end_s = played.frames / played.fps
        (merge,) = cues(played, "merge")
        strokes = cues(played, "strokes:")
        assert played.frames == 60
        assert strokes[0].from_s >= merge.to_s
        assert strokes[-1].to_s >= end_s  # no rest at the end
        tops = [
            max(speeds(told(played, side, cue.from_s, cue.to_s)[1]).max() for side in (0, 1))
            for cue in strokes
        ]
        assert 0.75 <= tops[0] <= 1.1
        assert 1.8 <= tops[-1] <= 2.5
        assert max(tops) <= 2.52
        third = len(tops) // 3
        assert np.mean(tops[-third:]) > 1.5 * np.mean(tops[:third])
        # Both hands are fast.
        for side in (0, 1):
            assert speeds(told(played, side, end_s - 3.0, end_s)[1]).max() > 1.8


def test_fast_finish_merges_in_both_views_and_then_hides_hands_in_part(seed):
    played = performance("fast_finish", seed)
    (merge,) = cues(played, "merge")
    times = np.arange(np.ceil(merge.to_s * 3) - 1, 60) / 3
    partly, together = 0, []
    with StereoRenderer(build(played.scene)) as renderer:
        for t_s in times.tolist():
            renderer.world.place(played.script.pose(t_s))
            views = [view_truth(view) for view in renderer.render(colour=False)]
            together.append(all(view.merged[RIGHT_HAND, LEFT_HAND] for view in views))
            least = min(view.visible_fractions[1:].min() for view in views)
            partly += 0.1 < least < 0.95
    assert together[0]
    assert 3 <= partly < len(times)
    assert 3 <= sum(together) < 0.7 * len(times)


def test_the_ladder_of_rates_plays_the_motion_of_natural_table(seeds):
    ladder, natural = load_scenario("fps_ladder"), load_scenario("natural_table")
    assert ladder.rates == (1, 2, 3, 5, 10, 15, 30)
    assert ladder.frames / ladder.fps == 10.0
    assert ladder.parameters == natural.parameters
    assert (ladder.stream, ladder.motion) == (natural.stream, natural.motion)
    for seed in seeds:
        assert concrete(ladder, seed) == concrete(natural, seed)


def test_at_every_rate_the_ladder_shows_the_same_poses():
    ladder = load_scenario("fps_ladder")
    for seed, rates in ((200, ladder.rates), (201, (1, 10)), (202, (2, 5))):
        played = [
            perform(ladder, seed, {"fps": rate, "frames": round(10 * rate)}) for rate in rates
        ]
        for t in (0.0, 1.0, 3.0, 6.0, 9.0):
            first, *others = (p.script.pose(t) for p in played)
            for pose in others:
                for a, b in zip(first.hands, pose.hands, strict=True):
                    np.testing.assert_array_equal(a.position_m, b.position_m)
                    np.testing.assert_array_equal(a.rotation, b.rotation)
                np.testing.assert_array_equal(first.head.position_m, pose.head.position_m)
