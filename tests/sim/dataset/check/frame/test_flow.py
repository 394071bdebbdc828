"""Damaged optical flow."""

import shutil

import cv2
import numpy as np
import pytest
from damaged_dataset import SEQ, edit_png, exchange, faults_of, files

from sim.dataset.files.layout import FLOW_ZERO

FORWARD, BACKWARD = "flow_forward_left", "flow_backward_left"
FRAME = "000002.png"


def changed(copy, change, where=slice(None)):
    """Faults after a change of a frame's forward flow, where the mask of its ids is `where`."""
    seg = cv2.imread(str(copy / SEQ / "seg_left" / FRAME), cv2.IMREAD_UNCHANGED)

    def edit(flow):
        mask = np.ones(seg.shape, bool) if where == slice(None) else np.isin(seg, where)
        flow[mask] = change(flow[mask].astype(np.int64)).clip(0, 65535)
        return flow

    edit_png(copy / SEQ / FORWARD / FRAME, edit)
    return faults_of(copy)


def along_x(flow):
    """A pixel more to the right; channels in OpenCV's order: status, dy, dx."""
    return flow + np.array([0, 0, 64])


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("change", "where", "text"),
    [
        (along_x, slice(None), "which stand still"),
        (along_x, [1], "elsewhere than its poses"),
        (lambda f: f + (f[:, :1] > 0) * np.array([0, 0, 64]), [2, 3, 4], "do not close"),
        (lambda f: f + np.array([7, 0, 0]), [2], "status"),
    ],
    ids=["all", "head", "hands and arms", "status"],
)
def test_other_flow_is_named(copy, change, where, text):
    faults = changed(copy, change, where)
    assert f"{SEQ}/{FORWARD}/{FRAME}" in files(faults)
    assert any(text in fault.text for fault in faults)
    # The way back is checked against it, and named as well where only both together are wrong.
    assert {name.rpartition("/")[0] for name in files(faults)} <= {
        f"{SEQ}/{FORWARD}",
        f"{SEQ}/{BACKWARD}",
    }


def test_flow_that_says_nothing_moves_is_named(copy):
    faults = changed(copy, lambda f: np.tile([1, int(FLOW_ZERO), int(FLOW_ZERO)], (len(f), 1)))
    assert f"{SEQ}/{FORWARD}/{FRAME}" in files(faults)


def test_exchanged_directions_are_named(copy):
    exchange(copy / SEQ / FORWARD / FRAME, copy / SEQ / BACKWARD / FRAME)
    named = files(faults_of(copy))
    assert f"{SEQ}/{FORWARD}/{FRAME}" in named
    assert f"{SEQ}/{BACKWARD}/{FRAME}" in named


def test_flow_where_there_is_no_neighbour_is_superfluous_and_a_lost_one_missing(copy):
    shutil.copy(copy / SEQ / FORWARD / FRAME, copy / SEQ / FORWARD / "000005.png")
    (copy / SEQ / BACKWARD / FRAME).unlink()
    faults = {fault.file: fault.text for fault in faults_of(copy)}
    assert faults == {
        f"{SEQ}/{FORWARD}/000005.png": "is of no frame",
        f"{SEQ}/{BACKWARD}/{FRAME}": "missing",
    }
