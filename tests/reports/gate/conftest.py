"""Runs of three scenarios: equal ones, worse ones, ones with swaps."""

import numpy as np
import pytest

from reports.run.load import load
from reports.run.save import RunInfo, save

GROUPS = {"calm": "baseline", "drink": "hand_and_head", "cross": "hand_and_hand"}


def make_episodes(episode_of, tools, worse=lambda scenario, seed: 0.0, swapped=(), seeds=8):
    """Runs of three scenarios; `worse` shifts all estimates by that much [m]."""
    for scenario, group in GROUPS.items():
        for seed in range(seeds):
            paths = tools.paths(24, 3.0, 0.1 + 0.01 * seed)
            said = tools.noisy(paths, seed) + np.array([0.0, 0.0, worse(scenario, seed)])
            if (scenario, seed) in swapped:
                said[8:, [1, 2]] = said[8:, [2, 1]]
            yield episode_of(said, scenario=scenario, group=group, seed=seed, centres_m=paths)


@pytest.fixture(scope="session")
def runs(episode_of, tools, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")

    def run_of(name, extra=(), drop=0, **changes):
        played = list(make_episodes(episode_of, tools, **changes))
        played = [*played[drop:], *extra]
        return load(save(folder / name, played, RunInfo(name)))

    return {
        "base": run_of("base"),
        "again": run_of("again"),
        "worse": run_of("worse", worse=lambda s, k: 0.012),
        "better": run_of("better", worse=lambda s, k: 0.0),
        "jitter": run_of("jitter", worse=lambda s, k: 0.0004 * (-1) ** k),
        "half": run_of("half", worse=lambda s, k: 0.03 if s == "drink" else 0.0),
        "swaps": run_of("swaps", swapped={("cross", k) for k in range(8)}),
        "one_swap": run_of("one_swap", swapped={("cross", 3)}),
        "fewer": run_of("fewer", drop=1),
    }


@pytest.fixture(scope="session")
def episodes(episode_of, tools):
    """Make the episodes of a run."""
    return lambda **changes: make_episodes(episode_of, tools, **changes)


@pytest.fixture(scope="session")
def groups():
    return GROUPS
