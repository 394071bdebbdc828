"""Splits: no room, body or seed in two of them, the same in any order."""

from dataclasses import replace

import pytest
from damaged_dataset import edit_json, faults_of, files
from hypothesis import given
from hypothesis import strategies as st

from sim.dataset.splits import KEYS, SHARES, SPLITS, SplitKeys, groups, leaks, split, splits_record
from sim.dataset.stored_sequence import StoredSequence

digests = st.integers(0, 12).map(str)
sequences = st.dictionaries(
    st.integers(0, 999).map("seq_{:06d}".format),
    st.builds(SplitKeys, room=digests, body=digests, seed=digests, frames=st.integers(1, 50)),
    max_size=12,
)


def shared(keys, one, other):
    return any(getattr(keys[one], key) == getattr(keys[other], key) for key in KEYS)


@given(sequences)
def test_nothing_is_shared_between_splits(keys):
    splits = split(keys)
    assert sorted(name for members in splits.values() for name in members) == sorted(keys)
    where = {name: s for s, members in splits.items() for name in members}
    # A second implementation: every pair, not chains.
    assert all(where[a] == where[b] for a in keys for b in keys if shared(keys, a, b))
    assert leaks(splits, keys) == []


@given(sequences, st.randoms())
def test_order_of_the_sequences_does_not_matter(keys, random):
    shuffled = list(keys.items())
    random.shuffle(shuffled)
    assert split(dict(shuffled)) == split(keys)


@given(sequences)
def test_groups_are_the_smallest(keys):
    """Within a group, every member is reached over shared keys."""
    for group in groups(keys):
        reached = {group[0]}
        for _ in group:
            reached |= {b for a in reached for b in group if shared(keys, a, b)}
        assert reached == set(group)


def test_shares_are_met_where_nothing_is_shared():
    keys = {f"seq_{i:06d}": SplitKeys(f"r{i}", f"b{i}", f"s{i}", 10) for i in range(50)}
    counts = {name: len(members) for name, members in split(keys).items()}
    assert counts == {name: round(50 * share) for name, share in SHARES.items()}


def test_three_groups_leave_no_split_empty():
    keys = {f"seq_{i:06d}": SplitKeys(f"r{i}", f"b{i}", f"s{i}", 5) for i in range(3)}
    assert all(len(members) == 1 for members in split(keys).values())
    one_room = {name: replace(own, room="r") for name, own in keys.items()}
    assert split(one_room) == {"train": sorted(keys), "val": [], "test": []}


def test_a_leak_is_said_with_its_key():
    keys = {"a": SplitKeys("r", "b", "1", 3), "b": SplitKeys("r2", "b", "2", 3)}
    assert leaks({"train": ["a"], "test": ["b"]}, keys) == ["b (test) has the body of a (train)"]
    apart = {**keys, "b": replace(keys["b"], body="b2")}
    assert leaks({"train": ["a"], "test": ["b"]}, apart) == []


@pytest.fixture
def divided(copies):
    """Three sequences, each of a room, body and seed of its own, with their splits."""
    for number in range(3):
        one = {"identity": {"room": f"r{number}", "body": f"b{number}"}, "seed": number}
        edit_json(copies / f"seq_{number:06d}" / "recipe.json", lambda r, one=one: r.update(one))
    stored = [StoredSequence(copies / f"seq_{number:06d}", {}) for number in range(3)]
    (copies / SPLITS).write_text("{}")
    edit_json(copies / SPLITS, lambda record: record.update(splits_record(stored)))
    return copies


def test_a_leak_between_splits_is_named_by_verify(divided):
    assert faults_of(divided) == []
    edit_json(divided / "seq_000002" / "recipe.json", lambda r: r["identity"].update(body="b0"))
    faults = faults_of(divided)
    assert files(faults) == [SPLITS]
    assert "has the body of" in faults[0].text


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "change",
    [
        lambda r: r.update(splits=["seq_000000"]),
        lambda r: r["splits"]["train"].append("seq_000000"),
        lambda r: r["splits"].update(train=[], val=[], test=[]),
    ],
)
def test_damaged_splits_are_named(divided, change):
    edit_json(divided / SPLITS, change)
    assert files(faults_of(divided)) == [SPLITS]
