"""The names by which results call a sequence of a data set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pjpdaf.errors import BenchError
from scenarios.play.from_dataset import (
    job_of_sequence,
)
from scenarios.play.job import digest_of
from scenarios.run.save_run import scenario_record
from scenarios.spec.draw import concrete
from sim.dataset.stored_sequence import StoredSequence


@dataclass(frozen=True)
class SequenceIdentity:
    """The names of a sequence in results, and the values that its scenario drew.

    entry: as in run.json (`scenarios.run.save_run.scenario_record`); note: a message for its user.
    """

    label: str
    group: str
    seed: int
    digest: str
    values: Mapping[str, float | str] = field(default_factory=dict)
    entry: Mapping[str, Any] = field(default_factory=dict)
    note: str = ""


def identity_of(sequence: StoredSequence) -> SequenceIdentity:
    """The identity by its recipe, as in a run; by the manifest where its recipe cannot be read.

    Raises BenchError where the manifest's entry is incomplete.
    """
    try:
        job = job_of_sequence(sequence)
    except BenchError as fault:
        # Scores need no scenario: an older data set keeps its worth.
        return replace(
            _identity_in_manifest(sequence), note=f"{fault} Its drawn values are left out."
        )
    values = {
        name: value if isinstance(value, int | float) else str(value)
        for name, value in concrete(job.scenario, job.seed, job.overrides, sequence.redrawn).items()
    }
    group = job.scenario.group
    return SequenceIdentity(job.name, group, job.seed, digest_of(job), values, scenario_record(job))


def _identity_in_manifest(sequence: StoredSequence) -> SequenceIdentity:
    entry = sequence.entry
    texts = {name: entry.get(name) for name in ("label", "group", "digest", "scenario")}
    wrong = [name for name, text in texts.items() if not isinstance(text, str) or len(text) > 200]
    seed = entry.get("seed")
    if wrong or isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise BenchError(
            f"{sequence.folder.parent / 'manifest.json'}: {sequence.name}: must have a "
            f"{wrong[0] if wrong else 'seed'}."
        )
    return SequenceIdentity(
        str(texts["label"]),
        str(texts["group"]),
        seed,
        str(texts["digest"]),
        entry={"scenario": texts["scenario"]},
    )
