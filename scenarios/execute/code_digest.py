"""The digest of the code that decides results, so that kept results of other code are refused."""

from __future__ import annotations

import hashlib
import importlib.util
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from importlib.resources import files
from pathlib import Path

from pjpdaf.plugins.registry import DETECTORS, TRACKERS

_PACKAGES = ("pjpdaf", "sim", "reports", "scenarios")
# Presentation and other verbs decide no result; what is left is at worst too careful.
_IGNORED = {
    *("cli", "console", "page", "pictures", "summary", "rerun", "catalogue", "footage", "gate"),
    *("corpus", "suites"),
}
_SUFFIXES = (".py", ".yaml", ".json", ".csv")


@cache
def code_digest() -> str:
    """SHA-256 of the sources of this installation, without those of pages and other verbs."""
    whole = hashlib.sha256()
    for package in _PACKAGES:
        root = Path(str(files(package)))
        for path in sorted(root.rglob("*")):
            parts = path.relative_to(root).parts
            if path.suffix in _SUFFIXES and not _IGNORED.intersection(parts):
                whole.update("/".join((package, *parts)).encode() + b"\0")
                whole.update(hashlib.sha256(path.read_bytes()).digest())
    return whole.hexdigest()


def plug_in_digest(name: str) -> str:
    """SHA-256 of the file of a plug-in's module; "" for a preset, or where it has no such file.

    name: as given to `--detector` or `--tracker`. The module is found, not imported.
    """
    module = name.partition(":")[0] if ":" in name else _module_of_entry_point(name)
    try:
        spec = importlib.util.find_spec(module) if module else None
    except (ImportError, ValueError):
        return ""
    path = None if spec is None or spec.origin is None else Path(spec.origin)
    return hashlib.sha256(path.read_bytes()).hexdigest() if path and path.is_file() else ""


def _module_of_entry_point(name: str) -> str:
    points: list[EntryPoint] = [
        point
        for group in (DETECTORS, TRACKERS)
        for point in entry_points(group=group)
        if point.name == name
    ]
    return points[0].module if points else ""
