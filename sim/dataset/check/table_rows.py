"""Rows of truth.parquet and objects.parquet: faults that show without any picture."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from pjpdaf.targets import TARGETS
from sim.camera.clock import MOST_OF_PERIOD
from sim.dataset.check.fault import FrameFault
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import OBJECTS, TRUTH
from sim.dataset.labels.records import CENTRE_KEYPOINTS
from sim.scene.world import CAMERAS

FAR_M = 0.35  # from a target's centre to its visible surface, at most


def check_times(name: str, tables: list[FrameTables], fps: float) -> Iterator[FrameFault]:
    """Check times and stamps, and that all rows of a frame share them."""
    file, last_s = f"{name}/{TRUTH}", -math.inf
    common = ("time_s", "stamp_s", "arrived_left", "arrived_right", "events")
    for i, frame in enumerate(tables):
        first = frame.rows[0]
        time_s, stamp_s, nominal_s = frame.truth.time_s, first["stamp_s"], i / fps
        if any(row[key] != first[key] for row in frame.rows for key in common):
            yield FrameFault(file, "rows of a frame", i, f"differ in one of {', '.join(common)}")
        if not abs(time_s - nominal_s) <= MOST_OF_PERIOD / fps + 1e-9 or not time_s > last_s:
            yield FrameFault(
                file, "time_s", i, f"is {time_s:.6g} s, rig.json has {fps:g} frames a second"
            )
        if stamp_s not in (time_s, nominal_s):
            yield FrameFault(file, "stamp_s", i, f"{stamp_s} s is neither time_s nor index / fps")
        last_s = time_s
        for row in frame.objects:
            if row["time_s"] != time_s:
                yield FrameFault(f"{name}/{OBJECTS}", "time_s", i, "is not that of truth.parquet")


def check_poses(name: str, tables: list[FrameTables]) -> Iterator[FrameFault]:
    """Check rotations, centres, visible surfaces and visible fractions."""
    file = f"{name}/{TRUTH}"
    for i, frame in enumerate(tables):
        truth = frame.truth
        off_m = np.abs(frame.keypoints_m[list(CENTRE_KEYPOINTS)] - truth.centres_m).max()
        if not off_m <= 1e-9:
            yield FrameFault(
                file, "keypoints_m", i, f"centres lie {off_m:.3g} m from x_m, y_m, z_m"
            )
        both = ((file, "target", frame.rows), (f"{name}/{OBJECTS}", "object", frame.objects))
        for table, key, rows in both:
            for row in rows:
                length = math.sqrt(sum((row[q] or 0.0) ** 2 for q in ("qw", "qx", "qy", "qz")))
                if not abs(length - 1) <= 1e-9:
                    kind = f"quaternion of {row[key]}"
                    yield FrameFault(table, kind, i, f"has the length {length:.6g}")
        for t, target in enumerate(TARGETS):
            seen = any(view.visible_px[t] > 0 for view in truth.views)
            far_m = np.linalg.norm(truth.surfaces_m[t] - truth.centres_m[t])
            if seen != bool(np.isfinite(far_m)) or far_m > FAR_M:
                text = f"is {far_m:.3g} m from the centre, its visible pixels say otherwise"
                yield FrameFault(file, f"surface of {target}", i, text)
            for camera, view in zip(CAMERAS, truth.views, strict=True):
                fraction = frame.rows[t][f"visible_fraction_{camera}"]
                wanted = view.visible_fractions[t]
                if fraction != wanted or not wanted <= 1:
                    kind = f"visible_fraction of {target}, {camera} view"
                    yield FrameFault(
                        file, kind, i, f"is {fraction}, visible / amodal is {wanted:.6g}"
                    )
