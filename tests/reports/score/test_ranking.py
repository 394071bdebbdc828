"""The order of the films: the worst episodes first, then the others by seed."""

import numpy as np
import pytest

from reports.run.rows import rows_of
from reports.score.ranking import badness, film_rank, went_wrong


def test_the_worst_come_first_and_then_the_good_by_seed(episode_of, tools):
    centres = tools.paths(30, 3.0)
    episodes = {}
    for seed, shift in enumerate((0.0, 0.2, 0.12, 0.5)):
        estimates = (
            centres + np.array([0.0, 0.0, 1.0]) * shift * (np.arange(30) > 12)[:, None, None]
        )
        episodes["x", seed] = rows_of(episode_of(estimates, centres_m=centres, seed=seed)).episodes
    episodes |= {("x", 5): episodes["x", 0], ("y", 0): episodes["x", 0]}
    order = sorted(episodes, key=lambda key: film_rank(key, episodes[key]))
    assert order == [("x", 3), ("x", 1), ("x", 2), ("x", 0), ("y", 0), ("x", 5)]
    assert not went_wrong(episodes["x", 0])
    share, mean = badness(episodes["x", 1])
    assert share == pytest.approx(17 / 30)
    assert mean == pytest.approx(200 * 17 / 30)
