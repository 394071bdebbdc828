"""The start of a worker: clean, as its server is, and forked. Ratios within one run.

Run with `pytest tests/bench --benchmark-enable`.
"""

import subprocess
import sys

import pytest
from worker_tasks import double

from scenarios.execute.local import PLAYED_WITH, local_executor


@pytest.mark.long
@pytest.mark.benchmark(group="start of a worker")
def test_clean_process_with_its_modules(benchmark):
    words = [sys.executable, "-c", f"import {', '.join(PLAYED_WITH)}"]
    benchmark.pedantic(subprocess.run, args=(words,), kwargs={"check": True}, rounds=2)


@pytest.mark.benchmark(group="start of a worker")
def test_forked(benchmark):
    def start():
        with local_executor(1) as executor:
            assert any(executor.outcomes(double, {0: 1}, 60.0))

    benchmark.pedantic(start, rounds=5, warmup_rounds=1)
