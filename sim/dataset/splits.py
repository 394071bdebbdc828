"""Splits of a data set for training, validation and testing that share no room, body or seed."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sim.dataset.stored_sequence import StoredSequence

SPLITS = "splits.json"
SHARES: Mapping[str, float] = {"train": 0.8, "val": 0.1, "test": 0.1}
KEYS = ("room", "body", "seed")


@dataclass(frozen=True)
class SplitKeys:
    """What a sequence may share with others of its split alone. frames: their number."""

    room: str
    body: str
    seed: str
    frames: int

    @staticmethod
    def of(sequence: StoredSequence) -> SplitKeys:
        """The keys of a stored sequence: digests and seed of its recipe.

        Sequences whose recipe has no digests count as of one room and body. Raises FileError.
        """
        known = sequence.identity
        return SplitKeys(
            room=str(known.get("room", ""))[:64],
            body=str(known.get("body", ""))[:64],
            seed=str(sequence.recipe.get("seed", ""))[:64],
            frames=sequence.frame_count,
        )


def split(keys: Mapping[str, SplitKeys]) -> dict[str, list[str]]:
    """Sequences by split, sorted: those that share a room, body or seed, in any chain, together.

    Groups go in the order of the SHA-256 of their keys, each to the split that has least of its
    share: the same sequences give the same splits, in any order, on any machine; three groups and
    more leave no split empty.
    """
    frames = dict.fromkeys(SHARES, 0)
    splits: dict[str, list[str]] = {name: [] for name in SHARES}
    for group in sorted(groups(keys), key=lambda group: _digest(group, keys)):
        name = min(SHARES, key=lambda name: frames[name] / SHARES[name])
        splits[name] += group
        frames[name] += sum(keys[member].frames for member in group)
    return {name: sorted(members) for name, members in splits.items()}


def groups(keys: Mapping[str, SplitKeys]) -> list[list[str]]:
    """The smallest groups of sequences of which no two share a room, body or seed."""
    parent = {name: name for name in keys}

    def root(name: str) -> str:
        while parent[name] != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    first: dict[tuple[str, str], str] = {}
    for name in sorted(keys):
        for key in KEYS:
            other = first.setdefault((key, getattr(keys[name], key)), name)
            parent[root(name)] = root(other)
    found: dict[str, list[str]] = {}
    for name in sorted(keys):
        found.setdefault(root(name), []).append(name)
    return list(found.values())


def splits_record(sequences: Sequence[StoredSequence]) -> dict[str, Any]:
    """The content of splits.json. Raises FileError where a recipe is damaged."""
    keys = {sequence.name: SplitKeys.of(sequence) for sequence in sequences}
    return {"shares": dict(SHARES), "apart_by": list(KEYS), "splits": split(keys)}


def leaks(splits: Mapping[str, Sequence[str]], keys: Mapping[str, SplitKeys]) -> list[str]:
    """A line for each room, body or seed that two splits share."""
    owner: dict[tuple[str, str], tuple[str, str]] = {}
    lines = []
    for name, members in splits.items():
        for member in members:
            for key in KEYS:
                value = getattr(keys[member], key)
                other, where = owner.setdefault((key, value), (member, name))
                if where != name:
                    lines.append(f"{member} ({name}) has the {key} of {other} ({where})")
    return lines


def _digest(group: Sequence[str], keys: Mapping[str, SplitKeys]) -> str:
    parts = sorted(f"{getattr(keys[name], key)}" for name in group for key in KEYS)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
