"""Delta debugging: the fewest changes that still have an effect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

Keeps = Callable[[tuple[str, ...]], bool]


def minimal_changes(names: Sequence[str], fails_with: Keeps) -> tuple[str, ...]:
    """Names of the changes that are needed for the failure, in their order.

    names: of all changes, those that are likely to go first; fails_with: whether it still fails
    with these changes alone, asked once of each set. Groups are undone whole, and halved where that
    cures it (Zeller and Hildebrandt 2002), until no single change can be undone any more.
    """
    fails_with = cache(fails_with)
    kept = tuple(names)
    while True:
        before = kept
        stack = [kept]
        while stack:
            group = stack.pop()
            rest = tuple(name for name in kept if name not in group)
            if group and fails_with(rest):
                kept = rest
            elif len(group) > 1:
                middle = len(group) // 2
                stack += [group[middle:], group[:middle]]
        # What was needed beside a change that went later may have become needless.
        if kept == before or len(kept) <= 1:
            return kept
