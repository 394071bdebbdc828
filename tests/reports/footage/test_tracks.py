"""Rows of tracks from real footage."""

import dataclasses

import numpy as np

from pjpdaf.interfaces import Estimates
from reports.footage.tracks import track_rows
from sim.scene.rig import stereo_rig
from sim.specs import RigSpec


def test_targets_behind_the_camera_and_waiting():
    rig = stereo_rig(RigSpec())
    left = dataclasses.replace(rig.left, R_cw=np.eye(3), t_cw=np.zeros(3))
    cameras = (left, dataclasses.replace(rig.right, R_cw=rig.R, t_cw=rig.T))
    waiting = track_rows(0, 0.0, cameras, Estimates.waiting())
    assert [row["u_left_px"] for row in waiting] == [None] * 3
    behind = Estimates(np.full((3, 3), -1.0), np.zeros((3, 3, 3)), np.zeros((3, 3)), ("lost",) * 3)
    rows = track_rows(1, 0.3, cameras, behind)
    assert rows[0]["z_m"] == -1.0
    assert rows[0]["u_left_px"] is None
    assert rows[0]["sd_x_m"] == 0.0
    assert [row["exchange_probability"] for row in rows] == [None] * 3
    doubtful = track_rows(1, 0.3, cameras, dataclasses.replace(behind, exchange_probability=0.25))
    assert [row["exchange_probability"] for row in doubtful] == [None, 0.25, 0.25]
