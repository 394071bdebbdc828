"""Events as rows, whatever a stranger wrote."""

from reports.dataset.event_rows import event_rows


def test_events_of_a_stranger_are_left_out_or_cut():
    pair = {"targets": ["head", "left_hand"], "view": "left"}
    events = {
        "merges": [{**pair, "first_frame": 2, "last_frame": 99}],
        "occlusions": [{"target": "head", "by": 3, "first_frame": 9, "last_frame": 9}, 7],
        "ambiguous": "often",
        "script": [{"event": "e", "first_frame": -1, "last_frame": 2}, {"event": "e" * 500}],
    }
    assert event_rows(events, 5) == [
        {"kind": "merges", "text": "head and left hand merged, left view", "spans": [[2, 4]]}
    ]
    many = [{"event": str(i), "first_frame": 0, "last_frame": 0} for i in range(1000)]
    assert len(event_rows({"script": many}, 5)) == 40
