"""Instance ids and amodal masks against the numbers that truth.parquet has of them.

Where two or more numbers of a mask differ, the mask's file is named; where one differs, the table.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from sim.dataset.check.fault import Fault, FrameFault
from sim.dataset.check.frame.arrays import FrameArrays, present
from sim.dataset.check.frame.mask_geometry import measured, merged
from sim.dataset.check.frame.skeleton_status import skeleton_faults
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import OBJECTS, TRUTH
from sim.dataset.frame_rows import FrameRow
from sim.dataset.labels.instances import FIRST_OBJECT, NOTHING
from sim.dataset.labels.records import NOT_LABELLED, VISIBLE
from sim.scene.world import CAMERAS

SAME_PX = 1e-6  # of a mean of whole numbers
SLIVER_PX, SLIVER = 4, 0.002  # of visible pixels that the amodal pass may have missed
_BOX = ("x", "y", "width", "height")


@dataclass(frozen=True, eq=False)
class MaskView:
    """A view with ids and its rows of the tables. names: of the instances by id, of rig.json."""

    frame: FrameArrays
    view: int
    tables: FrameTables
    names: Mapping[int, str]

    @property
    def camera(self) -> str:
        """The view's name."""
        return CAMERAS[self.view]

    def fault(self, kind: str, text: str) -> FrameFault:
        """A fault of truth.parquet in this frame."""
        return FrameFault(f"{self.frame.sequence}/{TRUTH}", kind, self.frame.index, text)


def check_seg(masks: MaskView) -> Iterator[Fault | FrameFault]:
    """Check the ids, and pixels, centroids, boxes, merges, keypoints and joints that they show."""
    seg, tables, view, camera = _seg(masks), masks.tables, masks.view, masks.camera
    file = masks.frame.file("seg", view)
    counts = np.bincount(seg.ravel(), minlength=256)
    unknown = [i for i in np.flatnonzero(counts).tolist() if i not in (NOTHING, *masks.names)]
    if unknown:
        yield Fault(file, f"has the id {unknown[0]}, which rig.json does not name")
        return
    table_faults: list[FrameFault] = []
    truth = tables.truth.views[view]
    for t, target in enumerate(TARGETS):
        count, centroid, box = measured(seg == 1 + t)
        listed_count, listed_box = truth.visible_px[t], truth.boxes_px[t]
        listed_centroid = truth.centroids_px[t]
        different: dict[str, tuple[object, object]] = {}
        if count != listed_count:
            different["visible pixels"] = count, listed_count
        if not _same(centroid, listed_centroid):
            different["centroid"] = centroid, listed_centroid
        if not _same(box, listed_box):
            different["box"] = box, listed_box
        if len(different) > 1:
            yield Fault(
                file,
                f"shows {count} pixels of {target}, box {_text(box)}; truth.parquet says "
                f"{listed_count}, box {_text(listed_box)}",
            )
            return
        for quantity, (measure, listed) in different.items():
            text = f"is {_text(listed)}, that of the mask is {_text(measure)}"
            table_faults.append(masks.fault(f"{quantity} of {target}, {camera} view", text))
    yield from table_faults
    for o, row in enumerate(tables.objects):
        count, listed_px = int(counts[FIRST_OBJECT + o]), row[f"visible_{camera}_px"]
        if count != listed_px:
            kind = f"visible pixels of {row['object']}, {camera} view"
            text = f"is {listed_px}, the mask has {count}"
            yield FrameFault(f"{masks.frame.sequence}/{OBJECTS}", kind, masks.frame.index, text)
    yield from _merge_faults(masks)
    yield from _keypoint_faults(masks)
    yield from skeleton_faults(masks.frame, masks.view, masks.tables)


def check_amodal(masks: MaskView) -> Iterator[Fault | FrameFault]:
    """Check the amodal masks: pixels, box, occluders and truncation, given ids without fault."""
    seg, amodal = _seg(masks), present(masks.frame.views[masks.view].amodal)
    camera, truth = masks.camera, masks.tables.truth.views[masks.view]
    file = masks.frame.file("amodal", masks.view)
    if int(amodal.max()) >= 1 << len(TARGETS):
        yield Fault(file, f"has bits above those of the {len(TARGETS)} targets")
        return
    table_faults: list[FrameFault] = []
    for t, target in enumerate(TARGETS):
        mask, visible_mask = (amodal >> t) & 1 > 0, seg == 1 + t
        row, of_target = masks.tables.rows[t], f"of {target}, {camera} view"
        count, _, box = measured(mask)
        visible = int(truth.visible_px[t])
        outside = int(np.count_nonzero(visible_mask & ~mask))
        if outside > SLIVER_PX + SLIVER * visible:
            yield Fault(file, f"lacks {outside} of {visible} visible pixels of {target}")
            return
        hidden = np.bincount(seg[mask & ~visible_mask], minlength=256)
        occluders = {
            masks.names.get(i, "nothing"): int(hidden[i]) for i in np.flatnonzero(hidden).tolist()
        }
        listed_occluders = {by["instance"]: by["pixels"] for by in row[f"occluded_by_{camera}"]}
        listed_box = _numbers(row, [f"amodal_box_{part}_{camera}_px" for part in _BOX])
        pairs = {
            "amodal pixels": (str(max(count, visible)), str(int(truth.amodal_px[t]))),
            "amodal box": (_text(box), _text(listed_box)),
            "occluded_by": (_text(occluders), _text(listed_occluders)),
        }
        different = {key: pair for key, pair in pairs.items() if pair[0] != pair[1]}
        if len(different) > 1:
            key, (measure, listed) = next(iter(different.items()))
            yield Fault(file, f"{key} {of_target}: {measure}; truth.parquet says {listed}")
            return
        for key, (measure, listed) in different.items():
            text = f"is {listed}, the mask has {measure}"
            table_faults.append(masks.fault(f"{key} {of_target}", text))
        share = row[f"truncation_{camera}"]
        clear = count > 0 and not (mask[[0, -1]].any() or mask[:, [0, -1]].any())
        if share is None or not 0 <= share <= 1 or (clear and share != 0):
            where = "clear of" if clear else "at"
            text = f"is {share}, the amodal mask is {where} the picture's border"
            table_faults.append(masks.fault(f"truncation {of_target}", text))
    yield from table_faults


def _merge_faults(masks: MaskView) -> Iterator[FrameFault]:
    seg, listed = _seg(masks), masks.tables.truth.views[masks.view].merged
    boxes = np.array([measured(seg == 1 + t)[2] for t in range(len(TARGETS))])
    for a, b in np.argwhere(merged(seg, boxes) != listed).tolist():
        text = "do not touch in the mask" if listed[a, b] else "are one blob in the mask"
        kind = f"merged_with of {TARGETS[a]}, {masks.camera} view"
        yield masks.fault(kind, f"{TARGETS[b]}: {text}")


def _keypoint_faults(masks: MaskView) -> Iterator[FrameFault]:
    seg, tables = _seg(masks), masks.tables
    height, width = seg.shape
    at = np.floor(tables.keypoints_px[masks.view] + 0.5)
    inside = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    status, k = tables.keypoint_status[masks.view], 0
    kind = f"keypoint_status, {masks.camera} view"
    for t, row in enumerate(tables.rows):
        for _ in row["keypoints_m"]:
            x, y = at[k].astype(int) if inside[k] else (0, 0)
            if bool(inside[k]) != (status[k] != NOT_LABELLED):
                yield masks.fault(kind, f"keypoint {k} has {status[k]}, inside: {inside[k]}")
            elif status[k] == VISIBLE and seg[y, x] != 1 + t:
                yield masks.fault(kind, f"keypoint {k} is visible, its pixel is not {TARGETS[t]}")
            k += 1


def _seg(masks: MaskView) -> np.ndarray:
    return present(masks.frame.views[masks.view].seg)


def _same(measure: Floats, listed: Floats) -> bool:
    return np.allclose(measure, listed, rtol=0, atol=SAME_PX, equal_nan=True)


def _numbers(row: FrameRow, names: list[str]) -> Floats:
    return np.array([np.nan if row[n] is None else row[n] for n in names], np.float64)


def _text(value: object) -> str:
    if isinstance(value, np.ndarray):
        return " ".join(f"{v:.6g}" for v in value.tolist())
    if isinstance(value, dict):
        return ", ".join(f"{name} {value[name]}" for name in sorted(value)) or "none"
    return str(value)
