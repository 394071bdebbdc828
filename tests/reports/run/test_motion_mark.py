"""The mark of a motion: the same for other rounding, another for any other motion."""

import numpy as np

from reports.run.motion_mark import SAME_MOTION_UM, motion_mark


def test_the_mark_of_a_motion_outlives_other_rounding_but_no_other_motion(tools):
    rng = np.random.default_rng(100)
    for seed in range(100, 120):
        centres_m = tools.paths(24, 3.0, 0.1 + 0.01 * (seed - 100))
        mark = np.array(motion_mark(centres_m).split(), dtype=int)

        def off(changed_m, mark=mark):
            return np.abs(np.array(motion_mark(changed_m).split(), dtype=int) - mark).max()

        assert off(centres_m + rng.normal(0, 1e-9, centres_m.shape)) <= SAME_MOTION_UM
        one = centres_m.copy()
        one[rng.integers(24), rng.integers(3), rng.integers(3)] += 0.005
        assert off(one) > 0
        assert off(centres_m + 1e-4) > SAME_MOTION_UM
        assert off(centres_m[:-1]) > SAME_MOTION_UM
        assert off(centres_m[:, [0, 2, 1]]) > SAME_MOTION_UM
