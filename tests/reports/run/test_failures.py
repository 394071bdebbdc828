"""Failures of a saved run: their kinds are stored; in older runs they are read from the text."""

from dataclasses import replace
from typing import get_args

import pytest

from reports.run.failures import failures_of
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure, FailureKind

KINDS = get_args(FailureKind)


@pytest.fixture
def run(tmp_path):
    failures = [
        EpisodeFailure("cross", seed, f"because of {kind}", "hand_and_hand", kind=kind)
        for seed, kind in enumerate(KINDS)
    ]
    return load(save(tmp_path / "run", [rows_of(one) for one in failures], RunInfo("run")))


def test_kinds_come_back(run):
    failures = failures_of(run)
    assert [failure.kind for failure in failures] == list(KINDS)
    assert [failure.seed for failure in failures] == list(range(len(KINDS)))
    assert failures[0] == EpisodeFailure(
        "cross", 0, "because of unposable", "hand_and_hand", kind="unposable"
    )


def test_an_older_run_says_it_in_its_text(run):
    older = {
        **run.meta["scenarios"][0],
        "failures": [
            {"seed": 0, "reason": "cannot be posed: too far"},
            {"seed": 1, "reason": "KeyError: 1"},
            {"seed": 2, "reason": "KeyError: 1", "kind": "of a newer version"},
        ],
    }
    run = replace(run, meta={**run.meta, "scenarios": [older]})
    assert [failure.kind for failure in failures_of(run)] == ["unposable", "exception", "exception"]
    without = {key: value for key, value in older.items() if key != "failures"}
    assert failures_of(replace(run, meta={**run.meta, "scenarios": [without]})) == []
