import numpy as np
import pytest

from scenarios.spec.draw import unjudged
from scenarios.spec.names import load_scenario
from sim.silhouettes.pose_track import one_by_one, pose_track

# The last two have contact in some frames, the third a carried object, a lean and a tilted head.
CASES = [
    ("natural_table", 3),
    ("recorded", 1),
    ("drink", 0),
    ("cross", 8001),
    ("hand_under_table", 0),
]


@pytest.mark.parametrize(("name", "draw"), CASES)
def test_all_moments_at_once_are_the_poses_of_the_script(name, draw):
    performance = unjudged(load_scenario(name), draw)
    times_s = [i / performance.fps for i in range(min(performance.frames, 40))]
    anatomy = performance.scene.anatomy
    together = pose_track(performance.script, anatomy, times_s)
    single = one_by_one(performance.script, anatomy, times_s)
    for field in ("centres_m", "shoulders_m", "elbows_m", "wrists_m", "curls"):
        np.testing.assert_allclose(
            getattr(together, field), getattr(single, field), atol=1e-12, err_msg=field
        )
    assert together.objects.keys() == single.objects.keys()
    parts = [
        (together.torso, single.torso),
        (together.head, single.head),
        *zip(together.hands, single.hands, strict=True),
        *((together.objects[name], single.objects[name]) for name in single.objects),
    ]
    for ours, theirs in parts:
        np.testing.assert_allclose(ours.positions_m, theirs.positions_m, atol=1e-12)
        np.testing.assert_allclose(ours.rotations, theirs.rotations, atol=1e-12)
