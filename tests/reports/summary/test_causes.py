"""Blame and error budget in words."""

import pandas as pd

from reports.summary.budget import Budget
from reports.summary.causes import blame_lines, budget_line


def test_stages_at_fault_are_counted_by_kind_of_event():
    events = pd.DataFrame(
        [
            ("swap", "association"),
            ("swap", "none"),
            ("swap", "association"),
            ("lost", "process"),
            ("recovered", ""),
        ],
        columns=["kind", "blame"],
    )
    assert blame_lines(events) == (
        "swaps: 2 association, 1 no single stage",
        "losses: 1 process model",
    )
    assert blame_lines(events.iloc[4:]) == ()


def test_the_budget_in_a_line_weighs_targets_by_their_frames():
    levels = {
        "grid": {"head": 1.0, "right_hand": 4.0, "left_hand": 4.0},
        "surface": {"head": 2.0, "right_hand": 8.0, "left_hand": 8.0},
        "detector": {"head": 2.0, "right_hand": 8.0, "left_hand": 8.0},
        "filter": {"head": 1.0, "right_hand": 7.0, "left_hand": 7.0},
        "association": {"head": 1.0, "right_hand": 10.0, "left_hand": 10.0},
    }
    line = budget_line(Budget(levels, {"head": 20, "right_hand": 5, "left_hand": 5}))
    assert line == (
        "mean error 4.0 mm: whole pixels +2.0; visible skin, not the body's centre +2.0; "
        "detector +0.0; filter -1.0; association +1.0"
    )
