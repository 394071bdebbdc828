"""Moments that are known to be possible, against the judgement moment by moment."""

import numpy as np
import pytest

from scenarios.spec.draw import unjudged
from scenarios.spec.names import load_scenario
from sim.contact.contact import ALLOWED_PENETRATION_M
from sim.motion.measure import fault_of
from sim.silhouettes.possible import surely_possible

# Faulty motions: `tests/sim/motion/test_measure.py` judges its own in both ways.
CASES = [
    ("hand_under_table", 0, {}),
    ("drink", 0, {}),
    ("mirror", 3, {}),
    ("one_view_occluder", 2, {}),
]


@pytest.mark.parametrize(("name", "draw", "values"), CASES)
def test_what_is_known_is_so_moment_by_moment(name, draw, values):
    script = unjudged(load_scenario(name), draw, values).script
    performer = getattr(script, "script", script)
    times_s = np.linspace(0.0, 12.0, 17).tolist()
    known = surely_possible(performer, times_s)
    single = [fault_of(performer, [t_s]) for t_s in times_s]
    assert not any(fault for fault, fine in zip(single, known, strict=True) if fine)
    whole = fault_of(performer, times_s)
    assert fault_of(performer, times_s, known.tolist()) == whole
    assert known.mean() > 0.3  # worth it
    assert ALLOWED_PENETRATION_M > 0.0005  # the overlap up to which `may_touch` says no
