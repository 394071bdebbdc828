"""Digests of the code that decides results, so that kept results of other code are refused."""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Iterable
from importlib.metadata import entry_points
from pathlib import Path

import sim
from pjpdaf.presets.registry import PRESETS
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
            for path in _sources(root / name)
            if not without.intersection(path.relative_to(root).parts)
        ),
    )


def plug_in_digest(name: str, group: str) -> str:
    """SHA-256 of the module or package of a detector or tracker; "" of a preset.

    group: of its entry points. Other modules that it imports are not looked at. Nothing is
    imported: not even the package that a module is in.
    """
    if name in PRESETS:
        return ""
    module = name
    for point in entry_points(group=group):
        if point.name == name:
            module = point.value
    top = module.partition(":")[0].partition(".")[0]
    spec = importlib.util.find_spec(top) if top else None
    if spec is None:
        return ""
    if spec.submodule_search_locations:
        folders = [Path(folder) for folder in spec.submodule_search_locations]
        return " ".join(files_digest(folder, _sources(folder)) for folder in folders)
    file = Path(spec.origin or "")
    return files_digest(file.parent, [file]) if file.is_file() else ""


def _sources(folder: Path) -> Iterable[Path]:
    """All files below a folder but compiled code."""
    return (p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
