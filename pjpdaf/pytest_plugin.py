"""pytest plug-in: play scenarios in a test, and hold their results against a baseline.

pytest loads this file at every start in every project: nothing but pytest is imported, and none of
our packages with names that a project may have itself, until a fixture is used.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest

from pjpdaf.entry import own_packages

_IMPLEMENTATION = "scenarios.run.pytest_plugin"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of the plug-in."""
    group = parser.getgroup("pjpdaf-bench")
    group.addoption(
        "--pjpdaf-baseline",
        metavar="DIR",
        help="Folder of the slim runs that assert_no_regression compares with.",
    )
    group.addoption(
        "--pjpdaf-update-baseline",
        action="store_true",
        help="Write them instead: what is played now becomes the baseline.",
    )
    group.addoption(
        "--pjpdaf-jobs", type=int, metavar="N", help="Worker processes of a run [all cores]."
    )


@pytest.fixture
def pjpdaf_run(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """Plays scenarios: `pjpdaf_run("cross", tracker="mine:make", seeds=3)` gives a `BenchRun`.

    Or a data set: `pjpdaf_run(dataset="sets/mine", preset="thesis")`. All arguments:
    docs/gate.md and `scenarios.run.pytest_plugin.PlayRun`.
    """
    with own_packages():
        return importlib.import_module(_IMPLEMENTATION).player(request, tmp_path)


@pytest.fixture
def assert_no_regression(request: pytest.FixtureRequest) -> Any:
    """`assert_no_regression(run)` fails the test unless the gate passes the run.

    Its base is DIR/NAME of --pjpdaf-baseline DIR, NAME being the test's;
    --pjpdaf-update-baseline writes it. margins: metric -> margin, as of `compare`. A test that
    asks for this fixture fails before it plays where the baseline is missing or of other episodes.
    """
    with own_packages():
        return importlib.import_module(_IMPLEMENTATION).checker(request)
