"""Damaged COCO files."""

import pytest
from damaged_dataset import edit_json, faults_of, files


def test_coco_boxes_that_count_from_1_are_named(plain_copy):
    path = plain_copy / "annotations" / "instances_right.json"

    def move(record):
        for one in record["annotations"]:
            one["bbox"][0] += 1

    edit_json(path, move)
    faults = faults_of(plain_copy)
    assert files(faults) == ["annotations/instances_right.json"]
    assert all(fault.text.startswith("bbox") for fault in faults)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "kind",
    ["area", "segmentation", "visible_fraction", "num_keypoints", "keypoints", "person", "lost"],
)
def test_damaged_coco_annotations_are_named(plain_copy, kind):
    path = plain_copy / "annotations" / "instances_left.json"

    def change(record):
        first, second = record["annotations"][:2]
        if kind == "lost":
            del record["annotations"][0]
        elif kind == "segmentation":
            first[kind], second[kind] = second[kind], first[kind]
        elif kind == "keypoints":
            second[kind][3] += 0.01
        elif kind == "person":
            person = next(one for one in record["annotations"] if one["track_id"] == 4)
            person["keypoints"][-1] = 1
        else:
            first[kind] += 1

    edit_json(path, change)
    assert files(faults_of(plain_copy)) == ["annotations/instances_left.json"]
