"""COCO's categories and ids, the same in every data set."""

from __future__ import annotations

from typing import Any

from pjpdaf.targets import TARGETS
from sim.dataset.labels.records import HAND_POINTS, HEAD_POINTS, KEYPOINTS

# Their order is part of the format: a new kind comes at the end.
OBJECT_KINDS = (
    "can",
    "cup",
    "box",
    "ball",
    "book",
    "post",
    "rod",
    "block",
    "sheet",
    "phone",
    "arm",
    "balloon",
    "picture",
    "chair",
)
FIRST_OBJECT_CATEGORY = 10
# Frames of a sequence at most, and ids of instances, of which ids are made: so a sequence has the
# same ids in every data set, and all stay below 2**53.
FRAMES, INSTANCES = 10_000_000, 256
# From the wrist to the palm and on to each tip; COCO counts keypoints from 1.
_HAND_BONES = [[1, 2], *([2, tip] for tip in range(3, len(HAND_POINTS) + 1))]


def pair_id(sequence: str, frame_index: int) -> int:
    """Id of the two pictures of a frame; unique in a data set."""
    return int(sequence.rpartition("_")[2]) * FRAMES + frame_index + 1


def image_id(sequence: str, frame_index: int, view: int) -> int:
    """Id of a picture; unique over both files."""
    return 2 * pair_id(sequence, frame_index) + view


def categories() -> list[dict[str, Any]]:
    """Categories, the same in every data set: targets with keypoints, then kinds of objects."""
    targets: list[dict[str, Any]] = []
    for t, target in enumerate(TARGETS):
        points, bones = (HAND_POINTS, _HAND_BONES) if t else (HEAD_POINTS, [[1, 2]])
        assert [name for owner, name in KEYPOINTS if owner == t] == list(points)
        targets.append(
            {
                "id": 1 + t,
                "name": target,
                "supercategory": "person",
                "keypoints": list(points),
                "skeleton": bones,
            }
        )
    return targets + [
        {"id": FIRST_OBJECT_CATEGORY + i, "name": kind, "supercategory": "object"}
        for i, kind in enumerate(OBJECT_KINDS)
    ]
