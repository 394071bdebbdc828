"""Instance ids and amodal masks against what truth.parquet counts of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from sim.dataset.check.fault import Claim, Fault
from sim.dataset.check.frame import Frame
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import OBJECTS, TRUTH
from sim.dataset.frame_rows import FrameRow
from sim.dataset.labels.instances import FIRST_OBJECT, NOTHING
from sim.dataset.labels.records import NOT_LABELLED, VISIBLE
from sim.labels import TOUCH_PX
from sim.scene.world import CAMERAS

SAME_PX = 1e-6  # of a mean of whole numbers
SLIVER_PX, SLIVER = 4, 0.002  # of visible pixels that the amodal pass may have missed
_BOX = ("x", "y", "width", "height")


def seg_faults(
    frame: Frame, told: FrameTables, view: int, names: Mapping[int, str]
) -> Iterator[Fault | Claim]:
    """Of the file of ids, if it is not of this frame; else of the table's numbers of it.

    Two of count, centroid and box that are wrong are the mask's fault, one is the table's.
    """
    seg = frame.eyes[view].seg
    assert seg is not None, "there is a mask to check"
    file, camera = frame.file("seg", view), CAMERAS[view]
    counts = np.bincount(seg.ravel(), minlength=256)
    unknown = [i for i in np.flatnonzero(counts).tolist() if i not in names and i != NOTHING]
    if unknown:
        yield Fault(file, f"has the id {unknown[0]}, which rig.json does not name")
        return
    claims: list[Claim] = []
    seen = told.truth.views[view]
    for t, target in enumerate(TARGETS):
        count, centroid, box = measured(seg == 1 + t)
        said = seen.visible_px[t], seen.centroids_px[t], seen.boxes_px[t]
        wrong = {
            "visible pixels": (count, said[0], count == said[0]),
            "centroid": (centroid, said[1], _same(centroid, said[1])),
            "box": (box, said[2], _same(box, said[2])),
        }
        bad = [what for what, (_, _, same) in wrong.items() if not same]
        if len(bad) > 1:
            yield Fault(
                file,
                f"shows {count} pixels of {target}, box {_text(box)}; truth.parquet says "
                f"{said[0]}, box {_text(said[2])}",
            )
            return
        for what in bad:
            mine, its, _ = wrong[what]
            text = f"is {_text(its)}, that of the mask is {_text(mine)}"
            claims.append(_claim(frame, f"{what} of {target}, {camera} view", text))
    yield from claims
    for thing, row in enumerate(told.objects):
        count, said_px = int(counts[FIRST_OBJECT + thing]), row[f"visible_{camera}_px"]
        if count != said_px:
            kind = f"visible pixels of {row['object']}, {camera} view"
            yield Claim(
                f"{frame.name}/{OBJECTS}", kind, frame.index, f"is {said_px}, the mask has {count}"
            )
    yield from _merge_claims(frame, told, view, seg)
    yield from _keypoint_claims(frame, told, view, seg)


def amodal_faults(
    frame: Frame, told: FrameTables, view: int, names: Mapping[int, str]
) -> Iterator[Fault | Claim]:
    """Of the amodal masks and what is counted in them, given ids that are right."""
    eye, camera = frame.eyes[view], CAMERAS[view]
    assert eye.amodal is not None, "there is a mask to check"
    assert eye.seg is not None, "there is a mask to check"
    file, seen = frame.file("amodal", view), told.truth.views[view]
    if int(eye.amodal.max()) >= 1 << len(TARGETS):
        yield Fault(file, f"has bits above those of the {len(TARGETS)} targets")
        return
    claims: list[Claim] = []
    for t, target in enumerate(TARGETS):
        mask, own = (eye.amodal >> t) & 1 > 0, eye.seg == 1 + t
        row, what = told.rows[t], f"of {target}, {camera} view"
        count, _, box = measured(mask)
        visible = int(seen.visible_px[t])
        outside = int(np.count_nonzero(own & ~mask))
        if outside > SLIVER_PX + SLIVER * visible:
            yield Fault(file, f"lacks {outside} of {visible} visible pixels of {target}")
            return
        said_box = _numbers(row, [f"amodal_box_{part}_{camera}_px" for part in _BOX])
        hidden = np.bincount(eye.seg[mask & ~own], minlength=256)
        mine = {names.get(i, "nothing"): int(hidden[i]) for i in np.flatnonzero(hidden).tolist()}
        said = {one["instance"]: one["pixels"] for one in row[f"occluded_by_{camera}"]}
        wrong = {
            "amodal pixels": (max(count, visible), int(seen.amodal_px[t])),
            "amodal box": (_text(box), _text(said_box)),
            "occluded_by": (_text(mine), _text(said)),
        }
        bad = [key for key, (found, told_) in wrong.items() if found != told_]
        if len(bad) > 1:
            found, told_ = wrong[bad[0]]
            yield Fault(file, f"{bad[0]} {what}: {found}; truth.parquet says {told_}")
            return
        for key in bad:
            found, told_ = wrong[key]
            claims.append(_claim(frame, f"{key} {what}", f"is {told_}, the mask has {found}"))
        share = row[f"truncation_{camera}"]
        clear = count > 0 and not (mask[[0, -1]].any() or mask[:, [0, -1]].any())
        if share is None or not 0 <= share <= 1 or (clear and share != 0):
            where = "clear of" if clear else "at"
            text = f"is {share}, the amodal mask is {where} the picture's border"
            claims.append(_claim(frame, f"truncation {what}", text))
    yield from claims


def measured(mask: NDArray[np.bool_]) -> tuple[int, Floats, Floats]:
    """Pixels, centroid (2,) and box (4,) x, y, width, height of a mask, NaN where it is empty."""
    rows, columns = (np.count_nonzero(mask, axis=axis) for axis in (1, 0))
    count = int(rows.sum())
    if count == 0:
        return 0, np.full(2, np.nan), np.full(4, np.nan)
    ys, xs = np.flatnonzero(rows), np.flatnonzero(columns)
    centroid = np.array([xs @ columns[xs], ys @ rows[ys]]) / count
    box = xs[0], ys[0], xs[-1] - xs[0] + 1, ys[-1] - ys[0] + 1
    return count, centroid, np.array(box, np.float64)


def merged(seg: NDArray[np.uint8], boxes: Floats) -> NDArray[np.bool_]:
    """Which targets' masks are within TOUCH_PX, directly or in a chain (T, T)."""
    T = len(TARGETS)
    joined = np.zeros((T, T), bool)
    for a, b in combinations(range(T), 2):
        joined[a, b] = joined[b, a] = _near(seg, 1 + a, 1 + b, boxes[a], boxes[b])
    for middle in range(T):
        joined |= joined[:, [middle]] & joined[middle]
    return joined & ~np.eye(T, dtype=bool)


def _near(seg: NDArray[np.uint8], a: int, b: int, box_a: Floats, box_b: Floats) -> bool:
    reach = TOUCH_PX + 1
    if not (np.isfinite(box_a[0]) and np.isfinite(box_b[0])):
        return False
    low = np.maximum(box_a[:2], box_b[:2]) - reach
    high = np.minimum(box_a[:2] + box_a[2:], box_b[:2] + box_b[2:]) + reach
    if np.any(low >= high):
        return False
    (x0, y0), (x1, y1) = np.maximum(low, 0).astype(int), high.astype(int)
    window = seg[y0:y1, x0:x1]
    if not (window == a).any():
        return False
    away = cv2.distanceTransform((window != a).astype(np.uint8), cv2.DIST_C, 3)
    return bool(np.any(away[window == b] < reach + 0.5))


def _merge_claims(
    frame: Frame, told: FrameTables, view: int, seg: NDArray[np.uint8]
) -> Iterator[Claim]:
    seen, camera = told.truth.views[view], CAMERAS[view]
    found = merged(seg, np.array([measured(seg == 1 + t)[2] for t in range(len(TARGETS))]))
    for a, b in np.argwhere(found != seen.merged).tolist():
        text = "do not touch in the mask" if seen.merged[a, b] else "are one blob in the mask"
        yield _claim(frame, f"merged_with of {TARGETS[a]}, {camera} view", f"{TARGETS[b]}: {text}")


def _keypoint_claims(
    frame: Frame, told: FrameTables, view: int, seg: NDArray[np.uint8]
) -> Iterator[Claim]:
    height, width = seg.shape
    at = np.floor(told.keypoints_px[view] + 0.5)
    inside = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    status, k = told.keypoint_status[view], 0
    kind = f"keypoint_status, {CAMERAS[view]} view"
    for t, row in enumerate(told.rows):
        for _ in row["keypoints_m"]:
            x, y = at[k].astype(int) if inside[k] else (0, 0)
            if bool(inside[k]) != (status[k] != NOT_LABELLED):
                yield _claim(frame, kind, f"keypoint {k} has {status[k]}, inside: {inside[k]}")
            elif status[k] == VISIBLE and seg[y, x] != 1 + t:
                yield _claim(frame, kind, f"keypoint {k} is visible, its pixel is not {TARGETS[t]}")
            k += 1


def _claim(frame: Frame, kind: str, what: str) -> Claim:
    return Claim(f"{frame.name}/{TRUTH}", kind, frame.index, what)


def _same(mine: Floats, said: Floats) -> bool:
    return np.allclose(mine, said, rtol=0, atol=SAME_PX, equal_nan=True)


def _numbers(row: FrameRow, names: list[str]) -> Floats:
    return np.array([np.nan if row[n] is None else row[n] for n in names], np.float64)


def _text(value: object) -> str:
    if isinstance(value, np.ndarray):
        return " ".join(f"{v:.6g}" for v in value.tolist())
    if isinstance(value, dict):
        return ", ".join(f"{name} {value[name]}" for name in sorted(value)) or "none"
    return str(value)
