"""Damaged points and angles of skeletons.parquet."""

import pytest
from damaged_dataset import SEQ, edit_rows, faults_of, files

from sim.dataset.export import coco
from sim.dataset.files.tables import SKELETON_SCHEMA

PATH = f"{SEQ}/skeletons.parquet"


def named(plain_copy):
    """The faults of a damaged copy, of its own files: COCO's repeat the damage."""
    return [
        fault
        for fault in faults_of(plain_copy)
        if not fault.file.startswith(f"{coco.export.folder}/")
    ]


def damaged(plain_copy, change, frame=2):
    def edit(row):
        if row["frame_index"] == frame:
            change(row)

    edit_rows(plain_copy, edit, "skeletons.parquet", SKELETON_SCHEMA)
    return named(plain_copy)


def moved(point, by, axis=0):
    point[axis] += by


HAND = "right_hand"


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("skeleton", "change", "text"),
    [
        (HAND, lambda r: moved(r["points_m"][7], 1e-4), "length of a bone"),
        (HAND, lambda r: moved(r["points_m"][0], 1e-4), "wrist and tips"),
        (HAND, lambda r: moved(r["points_left_px"][9], 0.05), "points, left view"),
        (HAND, lambda r: moved(r["finger_angles_rad"][1], 0.001, 2), "between bones"),
        (HAND, lambda r: moved(r["finger_angles_rad"][1], 0.001, 0), "in the palm"),
        ("person", lambda r: moved(r["points_m"][7], 1e-4), "length of an arm's bone"),
        ("person", lambda r: moved(r["points_m"][1], 1e-4, 1), "shape of the face"),
        ("person", lambda r: r["point_status_right"].__setitem__(12, 2), "point_status"),
        ("person", lambda r: r["point_status_left"].__setitem__(0, 0), "point_status"),
        (HAND, lambda r: r["points_m"].pop(), "wrong size"),
        (HAND, lambda r: r["finger_angles_rad"].pop(), "wrong size"),
        (HAND, lambda r: r.update(skeleton="left_hand"), "in this order"),
    ],
)
def test_damage_to_a_skeleton_is_named(plain_copy, skeleton, change, text):
    faults = damaged(plain_copy, lambda row: change(row) if row["skeleton"] == skeleton else None)
    assert files(faults) == [PATH]
    assert any(text in fault.text for fault in faults)
    assert any("frame 2" in fault.text or "in this order" in fault.text for fault in faults)


def test_exchanged_hands_are_named(plain_copy):
    """The rows of both hands are exchanged in all frames, their names are right."""
    rows = {}
    edit_rows(
        plain_copy,
        lambda row: rows.setdefault((row["frame_index"], row["skeleton"]), dict(row)),
        "skeletons.parquet",
        SKELETON_SCHEMA,
    )

    def exchange(row):
        if row["skeleton"] != "person":
            other = "left_hand" if row["skeleton"] == "right_hand" else "right_hand"
            row |= {**rows[row["frame_index"], other], "skeleton": row["skeleton"]}

    edit_rows(plain_copy, exchange, "skeletons.parquet", SKELETON_SCHEMA)
    assert files(named(plain_copy)) == [PATH]


def test_a_missing_table_is_named(plain_copy):
    (plain_copy / PATH).unlink()
    assert [str(fault) for fault in named(plain_copy)] == [f"{PATH}: missing"]
