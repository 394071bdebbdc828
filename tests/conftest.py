"""Makes tests/strategies.py and its like importable in every test; one thread a test process."""

import compileall
import gc
import os
import sys
from collections import Counter
from pathlib import Path

import pytest

# Last: tests/pjpdaf must not hide the package pjpdaf.
sys.path.append(str(Path(__file__).parent))

# What is printed is that of a plain terminal, wherever the tests are started.
for variable in ("TERM", "COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR"):
    os.environ.pop(variable, None)

# Tests render what they say that they render, and leave the user's cache alone.
os.environ["PJPDAF_BENCH_CACHE"] = "off"

if sys.dont_write_bytecode and "PYTEST_XDIST_WORKER" not in os.environ:
    # Where Python keeps no byte code, every new process would compile our sources again, for 0.4 s.
    for package in ("pjpdaf", "sim", "reports", "scenarios"):
        compileall.compile_dir(Path(__file__).parents[1] / package, quiet=2)

if "PYTEST_XDIST_WORKER" in os.environ:
    # One process a core: threads of libraries and of the rasteriser only get in each other's way.
    # Before anything loads them; their results are the same.
    for name, value in (
        ("LP_NUM_THREADS", "0"),
        ("OMP_NUM_THREADS", "1"),
        ("OPENCV_FOR_THREADS_NUM", "1"),
        ("OPENBLAS_NUM_THREADS", "1"),
        ("MKL_NUM_THREADS", "1"),
    ):
        os.environ.setdefault(name, value)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Of a test marked `sample(n)`, the cases after the first n are long ones."""
    seen = Counter()
    for item in items:
        for mark in item.iter_markers("sample"):
            test = item.nodeid.partition("[")[0]
            seen[test] += 1
            if seen[test] > mark.args[0]:
                item.add_marker(pytest.mark.long)


def pytest_collection_finish():
    """Thousands of tests and modules stay to the end: no collection of garbage looks at them."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture(scope="session")
def executor():
    """Two worker processes for all tests of this process: to start them costs seconds."""
    from scenarios.execute.local import local_executor

    with local_executor(2) as pool:
        yield pool
