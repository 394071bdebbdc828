"""Words for events: labels of frames, scored events, measures of a stress test."""

import pytest

from reports.score.robustness import GOALS
from reports.words import GOAL_WORDS, event_text, label_text, labels_text


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("merge:right_hand+left_hand:left_view", "hands merged, left view"),
        ("merge:head+left_hand:right_view", "head and left hand merged, right view"),
        ("merge:", " merged, "),
        ("hold:can", "holds can"),
        ("carry:left", "carry (left hand)"),
        ("speed:0.25", "stroke at 0.25 m/s"),
        ("speed:fast", "speed (fast)"),
        ("held_by:left", "held by left hand"),
        ("out:right_view", "out (right view)"),
        ("cross_back", "cross back"),
    ],
)
def test_labels_in_words(name, words):
    assert label_text(name) == words


def test_a_merge_in_both_views_is_said_once():
    pair = "merge:right_hand+left_hand"
    names = ("cross", f"{pair}:right_view", f"{pair}:left_view")
    assert labels_text(names) == "cross · hands merged, both views"
    assert labels_text(names[:2]) == "cross · hands merged, right view"
    assert labels_text(("",)) == ""


def test_events_in_words():
    hands = {"target": "right_hand", "other": "head"}
    assert event_text({"kind": "swap", **hands}) == "hands swapped"
    assert event_text({"kind": "capture", **hands}) == "right hand captured by head"
    assert event_text({"kind": "capture", "target": "head", "other": ""}) == "head captured by ?"


def test_every_goal_has_its_words():
    assert GOAL_WORDS.keys() == set(GOALS)
