"""Checks the recipes of a data set: a recipe that was edited makes another sequence."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from pjpdaf.errors import BenchError, FileError
from reports.run.provenance import package_versions
from scenarios.play.recipe import KIND, read_recipe
from sim.dataset.check.fault import Fault
from sim.dataset.reader import open_dataset
from sim.dataset.stored_sequence import StoredSequence

RECIPE = "recipe.json"


def recipe_faults(folder: Path, faulty: Collection[str] = ()) -> list[Fault]:
    """The recipes that their sequences cannot be made of again, also with fresh checksums.

    faulty: files that have faults already. A recipe of another version of this package is not
    judged: its scenario may have had other fields.
    """
    try:
        dataset = open_dataset(folder)
    except BenchError:
        return []  # named by the other checks
    files = {sequence.name: f"{sequence.name}/{RECIPE}" for sequence in dataset.sequences}
    return [
        Fault(files[sequence.name], text, "recipe")
        for sequence in dataset.sequences
        if files[sequence.name] not in faulty
        for text in _faults(sequence)
    ]


def _faults(sequence: StoredSequence) -> Iterator[str]:
    try:
        record = sequence.recipe
    except FileError:
        return  # named by the other checks
    if record.get("kind") != KIND:
        return  # of a data set that another program made
    made_with = record.get("made_with")
    versions = made_with.get("versions") if isinstance(made_with, dict) else None
    stated = versions.get("pjpdaf-bench") if isinstance(versions, dict) else None
    if stated not in (None, package_versions()["pjpdaf-bench"]):
        return
    try:
        read_recipe(record, sequence.folder)
    except BenchError as fault:
        yield str(fault).removeprefix(f"{sequence.folder / RECIPE}: ").rstrip(".")
