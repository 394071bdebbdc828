"""Events that did not happen, or are missing."""

from damaged_dataset import SEQ, edit_json, faults_of, files


def test_events_that_did_not_happen_or_are_missing_are_named(plain_copy):
    def damage(record):
        record["merges"] = [
            {"view": "left", "targets": ["head", "left_hand"], "first_frame": 1, "last_frame": 2}
        ]
        assert record["script"]
        record["script"] = []
        record["ambiguous"] = [{"first_frame": 0, "last_frame": 0}]

    edit_json(plain_copy / SEQ / "events.json", damage)
    faults = faults_of(plain_copy)
    assert files(faults) == [f"{SEQ}/events.json"]
    kinds = {fault.text.partition(":")[0] for fault in faults}
    assert kinds == {"merges", "ambiguous", "script"}
