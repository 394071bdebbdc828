"""The identity of a run changes with everything that decides its results."""

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.detector.external import DetectionTable
from scenarios.play.job import Job, System
from scenarios.run import identity
from scenarios.run.identity import job_key, run_identity
from scenarios.spec.names import load_scenario

JOB = Job(load_scenario("cross"), 3, {"frames": 4}, System())
TABLE = DetectionTable(np.array([0, 1]), np.zeros((2, 2)), np.ones(2), np.ones(2))
OTHERS = {
    "seed": replace(JOB, seed=4),
    "values": replace(JOB, overrides={"frames": 5}),
    "label": replace(JOB, label="mine"),
    "size": replace(JOB, size_px=(96, 72)),
    "tracker": replace(JOB, system=System(tracker="thesis")),
    "settings": replace(JOB, system=System(tracker_settings={"lost_after_s": "2"})),
    "films": replace(JOB, keep_film=True),
    "pictures": replace(JOB, keep_pictures=True),
    "detections": replace(JOB, detections=(TABLE, DetectionTable.empty())),
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_another_job_has_another_key(other):
    assert job_key(other) != job_key(JOB)
    assert run_identity([other], "default") != run_identity([JOB], "default")


def test_other_detections_have_another_key():
    moved = DetectionTable(TABLE.frames, TABLE.centres_px + 1, TABLE.sd_px, TABLE.areas_px)
    one, other = (replace(JOB, detections=(t, TABLE)) for t in (TABLE, moved))
    assert job_key(one) != job_key(other)


def test_a_sequence_counts_by_its_content(tmp_path):
    (tmp_path / "SHA256SUMS").write_text("one")
    job = replace(JOB, kept=tmp_path)
    before = job_key(job)
    (tmp_path / "SHA256SUMS").write_text("two")
    assert job_key(job) != before


def test_code_and_versions_count(monkeypatch):
    before = run_identity([JOB], "default")
    assert run_identity([JOB, OTHERS["seed"]], "default") != before
    for name, value in (
        ("code_digest", lambda: "another"),
        ("versions", lambda: {"numpy": "0"}),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(identity, name, value)
            assert run_identity([JOB], "default") != before
    assert run_identity([JOB], "default") == before
