"""The float arrays of the label `float` against the PNG files that round them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import FrameArrays
from sim.dataset.check.frame.correspondence import REACH_PX
from sim.dataset.files.layout import DEPTH_UNIT_M, DISPARITY_SCALE, FLOW_SCALE

HALF = 0.51  # of a file's unit


def check_depth_twin(frame: FrameArrays, view: int) -> Iterator[Fault]:
    """Check depth_m of the NPZ file against the depth file."""
    depth_m = frame.views[view].depth_m
    if depth_m is not None:
        text = f"depth_m differs from {frame.file('depth', view)} by up to {{:.3g}} m"
        yield from _twin_fault(frame, view, "depth_m", depth_m, HALF * DEPTH_UNIT_M, text)


def check_match_twins(frame: FrameArrays, view: int) -> Iterator[Fault]:
    """Check disparity_px and places_px of the NPZ file against the PNG files that are there."""
    arrays = frame.views[view]
    disparity_px = None if arrays.rectified is None else arrays.rectified.disparity_px
    places_px = None if arrays.matches is None else arrays.matches.places_px
    for key, array, scale in (
        ("disparity_px", disparity_px, DISPARITY_SCALE),
        ("places_px", places_px, FLOW_SCALE),
    ):
        if array is not None:
            text = f"{key} differs from its PNG by up to {{:.3g}} px"
            yield from _twin_fault(frame, view, key, array, HALF / scale + 1e-4, text)


def _twin_fault(
    frame: FrameArrays,
    view: int,
    key: str,
    rounded: NDArray[np.float32],
    allowed: float,
    text: str,
) -> Iterator[Fault]:
    floats, file = frame.views[view].floats, frame.file("float", view, ".npz")
    if floats is None:
        return
    exact = floats.get(key)
    if exact is None or exact.shape != rounded.shape:
        yield Fault(file, f"has no {key} of the pictures' size")
        return
    off = np.abs(exact.astype(np.float64) - rounded)
    if key == "places_px":
        ys, xs = np.mgrid[: rounded.shape[0], : rounded.shape[1]]
        own = np.stack([xs, ys], axis=-1).astype(np.float64)
        off[np.abs(rounded - own).max(axis=-1) >= REACH_PX] = 0.0  # the file has its end there
    largest = float(np.nanmax(off, initial=0.0))
    if largest > allowed:
        yield Fault(file, text.format(largest))
