"""The identity of a run: everything that decides its results, so that it can go on later."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.detector.external import DetectionTable
from pjpdaf.plugins.registry import DETECTORS, TRACKERS
from reports.run.provenance import versions
from scenarios.execute.code_digest import code_digest, plug_in_digest
from scenarios.play.job import Job, digest_of
from sim.dataset.files.checksums import sha256_of
from sim.dataset.files.layout import CHECKSUMS


def run_identity(jobs: Sequence[Job], preset: str) -> str:
    """SHA-256 of episodes, system, our code, that of plug-ins, and the versions of libraries."""
    system = jobs[0].system
    record = {
        "jobs": [job_key(job) for job in jobs],
        "preset": preset,
        "code": code_digest(),
        "versions": versions(),
        "plug-ins": [
            plug_in_digest(system.detector, DETECTORS),
            plug_in_digest(system.tracker, TRACKERS),
        ],
    }
    return _digest(record)


def job_key(job: Job) -> str:
    """SHA-256 of all of a job that decides its rows, but for code."""
    # A field that is new to a job counts from its first day.
    record = {field.name: getattr(job, field.name) for field in fields(job)}
    for name in ("scenario", "overrides", "size_px", "label", "use_cache"):
        del record[name]
    return _digest(
        record
        | {
            "name": job.name,
            "digest": digest_of(job),  # of scenario, overrides and size
            "system": asdict(job.system),
            "kept": None if job.kept is None else sequence_digest(job.kept),
            "detections": None if job.detections is None else [*map(_table, job.detections)],
        }
    )


def sequence_digest(folder: Path) -> str:
    """SHA-256 of the sums of a data set's sequence, "" where it has none."""
    path = folder / CHECKSUMS
    return sha256_of(path) if path.is_file() else ""


def _table(table: DetectionTable) -> Mapping[str, Any]:
    names = ("frames", "centres_px", "sd_px", "areas_px", "evidence")
    arrays = {name: getattr(table, name) for name in names}
    return {
        name: None if array is None else hashlib.sha256(np.asarray(array).tobytes()).hexdigest()
        for name, array in arrays.items()
    }


def _digest(record: object) -> str:
    text = json.dumps(record, sort_keys=True, separators=(",", ":"), default=str)
    return hashlib.sha256(text.encode()).hexdigest()
