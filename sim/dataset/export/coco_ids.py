"""COCO's categories and ids, the same in every data set."""

from __future__ import annotations

from typing import Any

from pjpdaf.targets import TARGETS
from sim.dataset.labels.instances import PERSON
from sim.dataset.labels.records import COCO_BODY, HAND_JOINTS, HEAD_POINTS

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
    "bottle",
    "plant",
    "laptop",
    "monitor",
    "desk_lamp",
    "papers",
    "bystander",
)
FIRST_OBJECT_CATEGORY = 10
# Frames of a sequence at most, and ids of instances, of which ids are made: so a sequence has the
# same ids in every data set, and all stay below 2**53.
FRAMES, INSTANCES = 10_000_000, 256
PERSON_CATEGORY = PERSON  # also the person's track: 1 to 3 are the targets, objects follow
# COCO counts keypoints from 1. From the wrist along each finger.
_HAND_BONES = [[1 if j == 0 else 4 * f + j + 1, 4 * f + j + 2] for f in range(5) for j in range(4)]
# The bones of COCO's own category person, in its order.
_BODY_BONES = [
    *([16, 14], [14, 12], [17, 15], [15, 13], [12, 13], [6, 12], [7, 13], [6, 7], [6, 8], [7, 9]),
    *([8, 10], [9, 11], [2, 3], [1, 2], [1, 3], [2, 4], [3, 5], [4, 6], [5, 7]),
]


def pair_id(sequence: str, frame_index: int) -> int:
    """Id of the two pictures of a frame; unique in a data set."""
    return int(sequence.rpartition("_")[2]) * FRAMES + frame_index + 1


def image_id(sequence: str, frame_index: int, view: int) -> int:
    """Id of a picture; unique over both files."""
    return 2 * pair_id(sequence, frame_index) + view


def categories() -> list[dict[str, Any]]:
    """Categories, the same in every data set.

    The targets and the person, with keypoints, then kinds of objects.
    """
    skeletons = (
        *(
            (name, HAND_JOINTS, _HAND_BONES) if t else (name, HEAD_POINTS, [[1, 2]])
            for t, name in enumerate(TARGETS)
        ),
        ("person", COCO_BODY, _BODY_BONES),
    )
    people: list[dict[str, Any]] = [
        {
            "id": number,
            "name": name,
            "supercategory": "person",
            "keypoints": list(points),
            "skeleton": [list(bone) for bone in bones],
        }
        for number, (name, points, bones) in enumerate(skeletons, 1)
    ]
    assert people[-1]["id"] == PERSON_CATEGORY
    return people + [
        {"id": FIRST_OBJECT_CATEGORY + i, "name": kind, "supercategory": "object"}
        for i, kind in enumerate(OBJECT_KINDS)
    ]
