"""manifest.json: the sequences of a data set, how they were made, and if all are there."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from sim.dataset.files.layout import KIND, MANIFEST, SCHEMA_VERSION
from sim.files import written_whole_file

LICENCE = "CC-BY-4.0"  # of the pictures and labels that are made


@dataclass(frozen=True)
class SequenceEntry:
    """A sequence of a data set.

    folder: its name; scenario, label, group, seed: of the episode (label: its name in results);
    rung: of the ladder, "" without a ladder; digest: of scenario, seed and changed values.
    """

    folder: str
    scenario: str
    label: str
    group: str
    seed: int
    rung: str
    digest: str
    frames: int
    fps: float


def manifest_record(
    entries: Sequence[SequenceEntry],
    settings: Mapping[str, Any],
    made_with: Mapping[str, Any],
    complete: bool,
    command: Sequence[str] = (),
) -> dict[str, Any]:
    """The content of manifest.json.

    settings: labels, size and all else that the pictures depend on; made_with: versions, renderer;
    command: arguments that make it again.
    """
    return {
        "kind": KIND,
        "schema": SCHEMA_VERSION,
        "complete": complete,
        "licence": LICENCE,
        "command": list(command),
        "settings": dict(settings),
        "made_with": dict(made_with),
        "total_frames": sum(entry.frames for entry in entries),
        "sequences": [asdict(entry) for entry in entries],
    }


def write_manifest(folder: Path, record: Mapping[str, Any]) -> None:
    """Write or replace manifest.json, whole or not at all. Raises BenchError of the disk."""
    with written_whole_file(folder / MANIFEST, "the manifest", replace=True) as path:
        path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
