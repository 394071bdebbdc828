"""splits.json: every sequence once, and no room, body or seed in two splits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from pjpdaf.errors import FileError
from sim.dataset.check.fault import Fault
from sim.dataset.splits import SPLITS, SplitKeys, leaks
from sim.dataset.stored_sequence import StoredSequence


def check_splits(record: dict[str, Any], sequences: Sequence[StoredSequence]) -> Iterator[Fault]:
    """Check the content of splits.json against the recipes; those that are damaged are left out."""
    splits = record.get("splits")
    if not isinstance(splits, dict) or not all(
        isinstance(names, list) for names in splits.values()
    ):
        yield Fault(SPLITS, "has no lists of sequences by split")
        return
    listed = [str(name) for names in splits.values() for name in names]
    names = [sequence.name for sequence in sequences]
    if sorted(listed) != sorted(names):
        wrong = sorted({*listed} ^ {*names}) or sorted({n for n in listed if listed.count(n) > 1})
        yield Fault(SPLITS, f"must name every sequence once; see {wrong[0][:40]}")
        return
    keys = {}
    for sequence in sequences:
        try:
            keys[sequence.name] = SplitKeys.of(sequence)
        except FileError:
            continue
    known = {name: [m for m in members if m in keys] for name, members in splits.items()}
    for line in leaks(known, keys):
        yield Fault(SPLITS, line)
