"""The tables of a sequence: schemas, rows of exact numbers, and the truth from rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from pjpdaf.targets import TARGETS
from sim.dataset.labels.instances import Instances
from sim.dataset.labels.records import HAND_SKELETONS, KEYPOINTS, SKELETON_SLICES, FrameLabels
from sim.scene.world import CAMERAS
from sim.truth import Truth, ViewTruth

_AXES, _QUATERNION, _BOX = "xyz", ("qw", "qx", "qy", "qz"), ("x", "y", "width", "height")
_F, _I, _S = pa.float64(), pa.int64(), pa.string()
_HIDDEN = pa.list_(pa.struct([("instance", _S), ("pixels", _I)]))


def _view_fields(view: str) -> list[tuple[str, pa.DataType]]:
    return [
        (f"u_{view}_px", _F),
        (f"v_{view}_px", _F),
        (f"visible_{view}_px", _I),
        (f"amodal_{view}_px", _I),
        (f"visible_fraction_{view}", _F),
        (f"truncation_{view}", _F),
        *((f"box_{part}_{view}_px", _F) for part in _BOX),
        *((f"amodal_box_{part}_{view}_px", _F) for part in _BOX),
        (f"occluded_by_{view}", _HIDDEN),
        (f"merged_with_{view}", pa.list_(_S)),
        (f"keypoints_{view}_px", pa.list_(pa.list_(_F))),
        (f"keypoint_status_{view}", pa.list_(pa.int8())),
    ]


# A row per frame and target.
TRUTH_SCHEMA = pa.schema(
    [
        ("frame_index", _I),
        ("time_s", _F),
        ("stamp_s", _F),
        *((f"arrived_{view}", pa.bool_()) for view in CAMERAS),
        ("target", _S),
        *((f"{a}_m", _F) for a in _AXES),
        *((q, _F) for q in _QUATERNION),
        *((f"v{a}_mps", _F) for a in _AXES),
        *((f"surface_{a}_m", _F) for a in _AXES),
        ("keypoints_m", pa.list_(pa.list_(_F))),
        *(field for view in CAMERAS for field in _view_fields(view)),
        ("events", pa.list_(_S)),
    ]
)
# A row per frame and object.
OBJECTS_SCHEMA = pa.schema(
    [
        ("frame_index", _I),
        ("time_s", _F),
        ("object", _S),
        *((f"{a}_m", _F) for a in _AXES),
        *((q, _F) for q in _QUATERNION),
        *((f"v{a}_mps", _F) for a in _AXES),
        *((f"visible_{view}_px", _I) for view in CAMERAS),
    ]
)
# A row per frame and skeleton.
SKELETON_SCHEMA = pa.schema(
    [
        ("frame_index", _I),
        ("time_s", _F),
        ("skeleton", _S),
        ("points_m", pa.list_(pa.list_(_F))),
        *(
            field
            for view in CAMERAS
            for field in (
                (f"points_{view}_px", pa.list_(pa.list_(_F))),
                (f"point_status_{view}", pa.list_(pa.int8())),
            )
        ),
        ("finger_angles_rad", pa.list_(pa.list_(_F))),
    ]
)


def truth_rows(
    stamp_s: float,
    arrived: Sequence[bool],
    truth: Truth,
    labels: FrameLabels,
    instances: Instances,
) -> list[dict[str, Any]]:
    """Rows of a frame for truth.parquet, one per target."""
    names = {instance.id: instance.name for instance in instances.table}
    rows = []
    for t, target in enumerate(TARGETS):
        keypoints = [k for k, (owner, _) in enumerate(KEYPOINTS) if owner == t]
        row: dict[str, Any] = {
            "frame_index": truth.index,
            "time_s": truth.time_s,
            "stamp_s": stamp_s,
            "target": target,
            **_numbers([f"{a}_m" for a in _AXES], truth.centres_m[t]),
            **_numbers(_QUATERNION, labels.quaternions[t]),
            **_numbers([f"v{a}_mps" for a in _AXES], truth.velocities_mps[t]),
            **_numbers([f"surface_{a}_m" for a in _AXES], truth.surfaces_m[t]),
            "keypoints_m": labels.keypoints_m[keypoints].tolist(),
            "events": list(truth.events),
        }
        for view, has_picture, seen, own in zip(
            CAMERAS, arrived, truth.views, labels.views, strict=True
        ):
            hidden = own.hidden_px[t]
            row |= {
                f"arrived_{view}": has_picture,
                **_numbers([f"u_{view}_px", f"v_{view}_px"], seen.centroids_px[t]),
                f"visible_{view}_px": int(seen.visible_px[t]),
                f"amodal_{view}_px": int(seen.amodal_px[t]),
                f"visible_fraction_{view}": float(seen.visible_fractions[t]),
                f"truncation_{view}": float(own.truncation[t]),
                **_numbers([f"box_{p}_{view}_px" for p in _BOX], seen.boxes_px[t]),
                **_numbers([f"amodal_box_{p}_{view}_px" for p in _BOX], own.amodal_boxes_px[t]),
                f"occluded_by_{view}": [
                    {"instance": names.get(i, "nothing"), "pixels": int(hidden[i])}
                    for i in np.flatnonzero(hidden).tolist()
                ],
                f"merged_with_{view}": [TARGETS[o] for o in np.flatnonzero(seen.merged[t])],
                f"keypoints_{view}_px": [_pair(p) for p in own.keypoints_px[keypoints]],
                f"keypoint_status_{view}": own.keypoint_status[keypoints].tolist(),
            }
        rows.append(row)
    return rows


def object_rows(truth: Truth, labels: FrameLabels) -> list[dict[str, Any]]:
    """Rows of a frame for objects.parquet, one per object."""
    return [
        {
            "frame_index": truth.index,
            "time_s": truth.time_s,
            "object": state.name,
            **_numbers([f"{a}_m" for a in _AXES], state.position_m),
            **_numbers(_QUATERNION, state.quaternion),
            **_numbers([f"v{a}_mps" for a in _AXES], state.velocity_mps),
            **{
                f"visible_{view}_px": int(view_labels.objects_px[i])
                for view, view_labels in zip(CAMERAS, labels.views, strict=True)
            },
        }
        for i, state in enumerate(labels.objects)
    ]


def skeleton_rows(truth: Truth, labels: FrameLabels) -> list[dict[str, Any]]:
    """Rows of a frame for skeletons.parquet, one per skeleton; only hands have finger angles."""
    rows: list[dict[str, Any]] = []
    for name, own in SKELETON_SLICES.items():
        of_hand = name in HAND_SKELETONS
        angles = labels.finger_angles_rad[HAND_SKELETONS.index(name)].tolist() if of_hand else []
        rows.append(
            {
                "frame_index": truth.index,
                "time_s": truth.time_s,
                "skeleton": name,
                "points_m": labels.skeleton_m[own].tolist(),
                "finger_angles_rad": angles,
            }
        )
        for view, view_labels in zip(CAMERAS, labels.views, strict=True):
            rows[-1] |= {
                f"points_{view}_px": [_pair(p) for p in view_labels.skeleton_px[own]],
                f"point_status_{view}": view_labels.skeleton_status[own].tolist(),
            }
    return rows


def _numbers(names: Sequence[str], values: Any) -> dict[str, float | None]:
    """Numbers by name, None for NaN."""
    return {n: None if v != v else v for n, v in zip(names, values.tolist(), strict=True)}


def _pair(point: Any) -> list[float | None]:
    return [None if v != v else v for v in point.tolist()]


def truth_of_rows(rows: Sequence[Mapping[str, Any]]) -> Truth:
    """The truth that the rows of a frame came from, bit for bit; rows in the order of TARGETS.

    Raises ValueError or KeyError for rows of another order or form.
    """
    if [row["target"] for row in rows] != list(TARGETS):
        raise ValueError(f"the targets must be {', '.join(TARGETS)}, in this order")
    first = rows[0]
    views = []
    for view in CAMERAS:
        merged = [[other in row[f"merged_with_{view}"] for other in TARGETS] for row in rows]
        views.append(
            ViewTruth(
                centroids_px=_array(rows, [f"u_{view}_px", f"v_{view}_px"]),
                visible_px=np.array([row[f"visible_{view}_px"] for row in rows], np.int64),
                amodal_px=np.array([row[f"amodal_{view}_px"] for row in rows], np.int64),
                boxes_px=_array(rows, [f"box_{part}_{view}_px" for part in _BOX]),
                merged=np.array(merged, bool),
            )
        )
    return Truth(
        index=int(first["frame_index"]),
        time_s=float(first["time_s"]),
        centres_m=_array(rows, [f"{a}_m" for a in _AXES]),
        velocities_mps=_array(rows, [f"v{a}_mps" for a in _AXES]),
        surfaces_m=_array(rows, [f"surface_{a}_m" for a in _AXES]),
        views=tuple(views),
        events=tuple(first["events"]),
    )


def _array(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Any:
    values = [[row[name] for name in names] for row in rows]
    return np.array([[np.nan if v is None else v for v in row] for row in values], np.float64)
