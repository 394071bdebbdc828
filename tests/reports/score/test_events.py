"""Events on constructed paths: what must and what must not count."""

import numpy as np
import pytest

from reports.score.events import count_events, find_events, frames_of, sustained, swap_margin
from reports.score.records import Episode

HEAD, RIGHT, LEFT = 0, 1, 2


def kinds(episode: Episode) -> list[tuple]:
    return [(e.kind, e.target, e.other, e.first, e.last, e.ended) for e in find_events(episode)]


def swapped(centres, first, last=None):
    estimates = centres.copy()
    estimates[first:last] = estimates[first:last][:, [HEAD, LEFT, RIGHT]]
    return estimates


def test_half_a_second_at_3_fps_is_two_frames():
    assert [frames_of(0.5, fps) for fps in (1, 2, 3, 4, 10, 30)] == [1, 1, 2, 2, 5, 15]
    assert frames_of(1.0, 3) == 3


def test_a_perfect_tracker_has_no_events(episode_of):
    assert kinds(episode_of()) == []


def test_margin_is_one_zero_and_minus_one(tools):
    centres = tools.paths(3, 3.0)
    assert swap_margin(centres, centres) == pytest.approx([1, 1, 1])
    assert swap_margin(centres, swapped(centres, 0)) == pytest.approx([-1, -1, -1])
    assert swap_margin(centres, centres[:, [HEAD, RIGHT, RIGHT]]) == pytest.approx([0, 0, 0])


def test_swap_and_back(episode_of, tools):
    centres = tools.paths(30, 3.0)
    found = kinds(episode_of(swapped(centres, 10, 16)))
    assert ("swap", RIGHT, LEFT, 10, 15, True) in found
    assert [k[0] for k in found if k[0] == "capture"] == []  # each took the other's: a swap


def test_swapped_from_frame_0_on_counts(episode_of, tools):
    episode = episode_of(swapped(tools.paths(30, 3.0), 0))
    events = find_events(episode)
    assert ("swap", RIGHT, LEFT, 0, 29, False) in kinds(episode)
    for hand in (RIGHT, LEFT):
        counts = count_events(events, hand)
        assert counts.ever_swapped
        assert counts.ever_lost
        assert counts.swapped_frames == 30
    assert not count_events(events, HEAD).ever_swapped


def test_one_frame_is_no_swap_at_3_fps_but_is_at_1(episode_of, tools):
    estimates = swapped(tools.paths(30, 3.0), 10, 11)
    assert kinds(episode_of(estimates)) == []
    found = kinds(episode_of(estimates, fps=1.0, centres_m=tools.paths(30, 3.0)))
    assert found == [("swap", RIGHT, LEFT, 10, 10, True)] + [
        k for k in found if k[0] in ("lost", "recovered")
    ]


def test_hands_closer_than_10_cm_are_no_evidence(episode_of, tools):
    centres = tools.paths(30, 3.0)
    centres[:, LEFT] = centres[:, RIGHT] + [0, 0.09, 0]
    assert kinds(episode_of(swapped(centres, 0), centres_m=centres)) == []


def test_a_swap_is_not_over_when_the_hands_meet(episode_of, tools):
    centres = tools.paths(30, 3.0)
    centres[12:14, LEFT] = centres[12:14, RIGHT] + [0, 0.05, 0]
    found = kinds(episode_of(swapped(centres, 10), centres_m=centres))
    assert ("swap", RIGHT, LEFT, 10, 29, False) in found


def test_a_swap_while_clapping_is_seen(episode_of, tools):
    # The hands are apart in every other frame only.
    centres = tools.paths(30, 3.0)
    centres[1::2, LEFT] = centres[1::2, RIGHT] + [0, 0.05, 0]
    found = kinds(episode_of(swapped(centres, 4, 13), centres_m=centres))
    assert [k for k in found if k[0] == "swap"] == [("swap", RIGHT, LEFT, 4, 12, True)]


def test_a_frozen_track_is_lost_even_where_it_ends_near_the_other_hand(episode_of, tools):
    # Hands change places while the tracks stay put: against the nearest truth this looks perfect.
    centres = tools.paths(30, 3.0)
    frozen = np.repeat(centres[:1], 30, axis=0)
    s = np.clip((np.arange(30) - 8) / 6, 0, 1)[:, None]
    right, left = centres[0, RIGHT], centres[0, LEFT]
    centres[:, RIGHT] = right + s * (left - right) + np.array([0, 0, 0.2]) * np.sin(np.pi * s)
    centres[:, LEFT] = left + s * (right - left)
    events = find_events(episode_of(frozen, centres_m=centres))
    for hand in (RIGHT, LEFT):
        counts = count_events(events, hand)
        assert counts.ever_lost
        assert counts.ever_swapped


def test_a_hand_that_comes_back_to_a_frozen_track_was_still_lost(episode_of, tools):
    centres = tools.paths(30, 3.0)
    frozen = np.repeat(centres[:1], 30, axis=0)
    centres[:, RIGHT] = centres[0, RIGHT] + np.array([0, 0, 0.3]) * np.sin(
        np.pi * np.clip((np.arange(30) - 8) / 12, 0, 1)[:, None]
    )
    events = find_events(episode_of(frozen, centres_m=centres))
    counts = count_events(events, RIGHT)
    assert counts.ever_lost
    assert counts.recoveries == 1


def test_coalesced_tracks_are_failures(episode_of, tools):
    centres = tools.paths(30, 3.0)
    both_right = centres[:, [HEAD, RIGHT, RIGHT]]
    found = kinds(episode_of(both_right))
    assert ("capture", LEFT, RIGHT, 0, 29, False) in found
    assert ("lost", LEFT, -1, 0, 29, False) in found
    middle = centres.copy()
    middle[:, RIGHT] = middle[:, LEFT] = centres[:, 1:].mean(axis=1)
    counts = count_events(find_events(episode_of(middle)), LEFT)
    assert counts.ever_lost or counts.captures


def test_a_hand_captured_by_the_head(episode_of, tools):
    estimates = tools.paths(30, 3.0)
    estimates[5:12, LEFT] = estimates[5:12, HEAD]
    found = kinds(episode_of(estimates))
    assert ("capture", LEFT, HEAD, 5, 11, True) in found
    assert ("lost", LEFT, -1, 5, 11, True) in found
    assert ("recovered", LEFT, -1, 5, 12, True) in found


def test_lost_needs_a_second_and_more_than_15_cm(episode_of, tools):
    centres = tools.paths(30, 3.0)
    for frames, offset, expected in ((3, 0.16, 1), (2, 0.16, 0), (10, 0.14, 0)):
        estimates = centres.copy()
        estimates[10 : 10 + frames, LEFT, 1] += offset
        losses = [e for e in find_events(episode_of(estimates)) if e.kind == "lost"]
        assert len(losses) == expected, (frames, offset)


def test_recovery_needs_10_cm_for_half_a_second(episode_of, tools):
    estimates = tools.paths(30, 3.0)
    estimates[10:14, LEFT, 1] += 0.3
    estimates[14:18, LEFT, 1] += 0.12  # better, not good
    estimates[18, LEFT, 1] += 0.05  # one frame
    estimates[19, LEFT, 1] += 0.12
    found = [e for e in find_events(episode_of(estimates)) if e.kind in ("lost", "recovered")]
    assert [(e.kind, e.first, e.last) for e in found] == [("lost", 10, 13), ("recovered", 10, 20)]
    assert found[1].duration_s == pytest.approx(10 / 3)
    assert count_events(tuple(found), LEFT).recovery_s == pytest.approx(10 / 3)


def test_waiting_at_the_start_is_no_loss_but_never_starting_is(episode_of, tools):
    estimates = tools.paths(30, 3.0)
    estimates[:8] = np.nan
    assert kinds(episode_of(estimates)) == []
    estimates[:] = np.nan
    assert kinds(episode_of(estimates)) == [("lost", t, -1, 0, 29, False) for t in (0, 1, 2)]
    estimates = tools.paths(30, 3.0)
    estimates[20:, LEFT] = np.nan  # gives up
    assert ("lost", LEFT, -1, 20, 29, False) in kinds(episode_of(estimates))


def test_sustained_by_hand():
    def flags(text, letter):
        return np.array([c == letter for c in text])

    def spans(text, gap):
        found = sustained(flags(text, "b"), flags(text, "g"), 2, 2, gap)
        return [(s.first, s.last, s.ended) for s in found]

    assert spans("gbbbgg", 0) == [(1, 3, True)]
    assert spans("b.bggg", 0) == []
    assert spans("b.bggg", 1) == [(0, 2, True)]
    assert spans("b..bgg", 1) == []
    assert spans("bbgbgb", 0) == [(0, 5, False)]  # one good frame at a time is not the end
    assert spans("bbggbb", 0) == [(0, 1, True), (4, 5, False)]
