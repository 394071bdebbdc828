"""Digests of the code that decides results, so that kept results of other code are refused."""

from __future__ import annotations

import functools
from pathlib import Path

import sim
from pjpdaf.presets.registry import PRESETS
from sim.families.plugged import source_digest, sources_below
from sim.files import files_digest

PACKAGES = ("pjpdaf", "sim", "reports", "scenarios")
# Folders of presentation and of other verbs, which decide no result of a trial.
NO_TRIAL = frozenset(
    {
        *("cli", "console", "page", "pictures", "summary", "rerun", "catalogue", "footage", "gate"),
        *("corpus", "suites"),
    }
)


@functools.cache
def code_digest(without: frozenset[str] = frozenset()) -> str:
    """SHA-256 of the sources of our packages; without: names of folders that do not count."""
    root = Path(str(sim.__file__)).parent.parent
    return files_digest(
        root,
        (
            path
            for name in PACKAGES
            for path in sources_below(root / name)
            if not without.intersection(path.relative_to(root).parts)
        ),
    )


def plug_in_digest(name: str, group: str) -> str:
    """SHA-256 of the module or package of a detector or tracker; "" of a preset.

    Otherwise as `sim.families.plugged.source_digest`.
    """
    return "" if name in PRESETS else source_digest(name, group)
