"""Benchmarks are quick tests only where they are asked for: what they call has tests of its own."""

from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Without `--benchmark-enable` all of this folder is long."""
    if not config.getoption("benchmark_enable"):
        for item in items:
            if HERE in item.path.parents:
                item.add_marker(pytest.mark.long)
