"""Seeds for the tests of sim: few by default, the others of a module's SEEDS with `-m long`."""

import pytest
from hypothesis import settings

# How long an example takes on a busy machine is no property of what is tested.
settings.register_profile("any-machine", deadline=None)
settings.load_profile("any-machine")


def pytest_generate_tests(metafunc):
    """`seeds` is the first FEW (1) of the module's SEEDS, then the rest; `seed` is one of them."""
    given = {mark.args[0] for mark in metafunc.definition.iter_markers("parametrize")}
    few, every = getattr(metafunc.module, "FEW", 1), getattr(metafunc.module, "SEEDS", ())
    long = pytest.mark.long
    if "seeds" in metafunc.fixturenames:
        both = [every[:few], pytest.param(every[few:], marks=long)]
        metafunc.parametrize("seeds", both, ids=["few", "more"])
    elif "seed" in metafunc.fixturenames and "seed" not in given:
        assert every, f"{metafunc.module.__name__} needs SEEDS: without, its tests would be skipped"
        one = [*every[:few], *(pytest.param(seed, marks=long) for seed in every[few:])]
        metafunc.parametrize("seed", one)
