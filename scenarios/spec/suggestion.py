"""Suggestions for a misspelt name."""

from __future__ import annotations

from collections.abc import Collection

from pjpdaf.errors import FEW, closest


def did_you_mean(name: str, known: Collection[str]) -> str:
    """Return "; did you mean X?" for the known names most like `name`, "" where none is like it."""
    near = closest(name, known)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def suggestion(name: str, known: Collection[str], everything: str = "") -> str:
    """Return `did_you_mean`; where no name is like it, all of a few names, or where all are listed.

    everything: the command that lists the names.
    """
    hint = did_you_mean(name, known)
    if hint:
        return hint
    if len(known) > FEW and everything:
        return f"; `{everything}` lists all {len(known)}"
    return f"; known: {', '.join(known if len(known) <= FEW else sorted(known))}"
