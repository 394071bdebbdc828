"""A phone held at the ear."""

from __future__ import annotations

import numpy as np
import pytest
from performances import HANDS, cues, drawn, performance

SEEDS = range(200, 203)


def test_the_phone_is_held_at_the_ear_for_3_to_15_s(seeds):
    for seed in seeds:
        played, values = performance("phone_at_ear", seed), drawn("phone_at_ear", seed)
        (held,) = cues(played, "at_ear")
        assert held.to_s - held.from_s == pytest.approx(values["hold"])
        assert 3.0 <= values["hold"] <= 15.0
        anatomy, side = played.scene.anatomy, HANDS.index(values["hand"])
        for t in np.linspace(held.from_s, held.to_s, 5).tolist():
            pose = played.script.pose(t)
            ear = np.array([0.0, (-0.5, 0.5)[side] * anatomy.head_breadth_m, 0.0])
            ear = pose.head.position_m + pose.head.rotation @ ear
            phone = pose.objects["phone"]
            local = phone.rotation.T @ (ear - phone.position_m)
            beyond = np.abs(local - [0.0, 0.0, 0.0045]) - [0.036, 0.074, 0.0045]
            assert np.linalg.norm(np.maximum(beyond, 0.0)) < 0.03
            assert abs(phone.rotation[1, 2]) > 0.7  # its face towards the head


def test_the_elbow_of_the_phone_s_arm_is_off_the_table_and_below_the_shoulder(seeds):
    for seed in seeds:
        played, values = performance("phone_at_ear", seed), drawn("phone_at_ear", seed)
        (held,) = cues(played, "at_ear")
        arm = played.script.body(held.from_s + 0.5).arms[HANDS.index(values["hand"])]
        assert arm.elbow_m[2] > played.scene.room.table_height_m + 0.03
        assert arm.elbow_m[2] < arm.shoulder_m[2]


def test_the_phone_lies_again_where_it_is_put(seeds):
    for seed in seeds:
        played, values = performance("phone_at_ear", seed), drawn("phone_at_ear", seed)
        (hold,) = played.script.plan.holds
        first = played.script.pose(0.0).objects["phone"]
        last = played.script.pose(hold.to_s + 1.0).objects["phone"]
        outward = (-1.0, 1.0)[hold.side]
        moved = [values["put_dx"], outward * values["put_dy"], 0.0]
        np.testing.assert_allclose(last.position_m - first.position_m, moved, atol=3e-3)
        before = played.script.pose(hold.to_s - 1e-6).objects["phone"]
        assert np.linalg.norm(before.position_m - last.position_m) < 3e-3
