"""Fast motion: speeds, brakes, reversals, the thesis's fast end, and the ladders of rates."""

from __future__ import annotations

import numpy as np
import pytest
from performances import (
    HANDS,
    cues,
    drawn,
    end_s,
    halved,
    performance,
    planned,
    speeds,
    truths,
)

from pjpdaf.targets import LEFT_HAND, RIGHT_HAND
from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.vectors import norm

SEEDS = range(200, 203)
DT_S = 0.002


def path_of(played, side, from_s, to_s):
    """Times (n,) and the places (n, 3) [m] to which the plan sends a hand."""
    return planned(played.script.plan.hands[side], from_s, to_s, DT_S)


def test_strokes_go_from_slow_to_fast_and_stop_within_the_brake(seeds):
    peaks = []
    for seed in seeds:
        played = performance("stop_and_reverse", seed)
        brake = drawn("stop_and_reverse", seed)["brake"]
        for cue in cues(played, "stop:"):
            side = HANDS.index(cue.name.partition(":")[2])
            times, path = path_of(played, side, cue.from_s, cue.to_s)
            speed = speeds(path, DT_S)
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
        reversals = cues(played, "reverse:")
        assert len(reversals) >= 6
        for cue in reversals:
            side = HANDS.index(cue.name.partition(":")[2])
            _, path = path_of(played, side, cue.from_s, cue.to_s)
            away = np.linalg.norm(path - path[0], axis=1)
            turn = int(away.argmax())
            assert away[-1] < 0.005
            assert away[turn] > 0.05
            # It turns at once: it is slow there for less than a fifth of a second.
            slow = speeds(path, DT_S) < 0.1 * speeds(path, DT_S).max()
            assert slow[turn - 60 : turn + 60].sum() * DT_S < 0.2
            out, back = path[turn] - path[0], path[-1] - path[turn]
            assert float(out @ back) < -0.99 * norm(out) * norm(back)


def test_both_hands_stop_and_reverse_in_every_seed(seeds):
    for seed in seeds:
        names = {cue.name for cue in cues(performance("stop_and_reverse", seed))}
        assert names >= {f"{kind}:{hand}" for kind in ("stop", "reverse") for hand in HANDS}


def test_fast_finish_merges_and_then_grows_from_0_8_to_2_5_mps_up_to_the_end(seeds):
    for seed in seeds:
        played = performance("fast_finish", seed)
        end = end_s(played)
        (merge,) = cues(played, "merge")
        strokes = cues(played, "strokes:")
        assert played.frames == 60
        assert strokes[0].from_s >= merge.to_s
        assert strokes[-1].to_s >= end  # no rest at the end
        tops = [
            max(
                speeds(path_of(played, side, cue.from_s, cue.to_s)[1], DT_S).max()
                for side in (0, 1)
            )
            for cue in strokes
        ]
        assert 0.75 <= tops[0] <= 1.1
        assert 1.8 <= tops[-1] <= 2.5
        assert max(tops) <= 2.52
        third = len(tops) // 3
        assert np.mean(tops[-third:]) > 1.5 * np.mean(tops[:third])
        # Both hands are fast.
        for side in (0, 1):
            assert speeds(path_of(played, side, end - 3.0, end)[1], DT_S).max() > 1.8


@pytest.mark.long
def test_fast_finish_merges_in_both_views_and_then_hides_hands_in_part(seed):
    played = performance("fast_finish", seed)
    (merge,) = cues(played, "merge")
    times = np.arange(np.ceil(merge.to_s * 3) - 1, 60) / 3
    partly, together = 0, []
    for views in truths(halved(played), times.tolist()):
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


@pytest.mark.long
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


@pytest.mark.long
def test_the_ladder_climbs_through_its_rungs():
    labels = [f"speed:{v:g}" for v in (0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3)]
    for seed in (0, 1):
        played = performance("speed_ladder", seed)
        side = HANDS.index(drawn("speed_ladder", seed)["hand"])
        rungs = {cue.name: cue for cue in cues(played)}
        assert list(rungs) == labels
        assert list(rungs.values())[-1].to_s <= played.frames / played.fps
        for label, rung in rungs.items():
            assert rung.to_s - rung.from_s >= 2.4
            speed = float(label.split(":")[1])
            dt_s = 0.02 / max(speed, 0.5)
            last_s = min(rung.to_s, rung.from_s + 4 * 1.875 * 0.35 / speed)
            times = np.arange(rung.from_s, last_s, dt_s).tolist()
            path = np.array([played.script.body(t).arms[side].palm_m for t in times])
            assert speeds(path, dt_s).max() == pytest.approx(speed, rel=0.06, abs=0.03)
            assert np.ptp(path[:, 1]) == pytest.approx(0.35, abs=0.02)
            assert label in played.script.events(rung.from_s)
