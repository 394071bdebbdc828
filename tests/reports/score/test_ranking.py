"""The order of the worst episodes."""

import numpy as np
import pytest

from reports.run.rows import rows_of
from reports.score.ranking import badness, went_wrong, worst_first


def test_the_worst_come_first_and_the_good_not_at_all(episode_of, tools):
    centres = tools.paths(30, 3.0)
    episodes = {}
    for seed, shift in enumerate((0.0, 0.2, 0.12, 0.5)):
        estimates = (
            centres + np.array([0.0, 0.0, 1.0]) * shift * (np.arange(30) > 12)[:, None, None]
        )
        episodes["x", seed] = rows_of(episode_of(estimates, centres_m=centres, seed=seed)).episodes
    assert worst_first(episodes) == [("x", 3), ("x", 1), ("x", 2)]
    assert not went_wrong(episodes["x", 0])
    share, mean = badness(episodes["x", 1])
    assert share == pytest.approx(17 / 30)
    assert mean == pytest.approx(200 * 17 / 30)
