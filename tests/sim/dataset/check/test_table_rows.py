"""Damaged columns and rows of the tables."""

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from damaged_dataset import SEQ, edit_rows, faults_of, files

from sim.dataset.files.tables import OBJECTS_SCHEMA


def test_boxes_that_count_from_1_are_named(plain_copy):
    def move(row):
        for axis in "xy":
            for camera in ("left", "right"):
                row[f"box_{axis}_{camera}_px"] += 1

    edit_rows(plain_copy, move)
    faults = [fault for fault in faults_of(plain_copy) if fault.file == f"{SEQ}/truth.parquet"]
    assert any("box of right_hand, left view" in fault.text for fault in faults)
    assert all("in 4 more frames" in fault.text for fault in faults)


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    ("column", "change"),
    [
        ("visible_fraction_left", lambda v: v * 0.99),
        ("amodal_right_px", lambda v: v + 1),
        ("u_left_px", lambda v: v + 0.5),
        ("surface_x_m", lambda v: v + 0.005),
        ("x_m", lambda v: v + 0.001),
        ("qw", lambda v: v + 0.01),
        ("time_s", lambda v: v * 3),
        ("truncation_left", lambda v: 0.5),
        ("amodal_box_width_left_px", lambda v: v + 1),
        ("keypoints_left_px", lambda v: [[x + 1, y] for x, y in v]),
        ("merged_with_left", lambda v: ["head", "right_hand", "left_hand"]),
        ("occluded_by_right", lambda v: [{"instance": "table", "pixels": 900}]),
    ],
)
def test_a_damaged_column_is_named(plain_copy, column, change):
    def damage(row):
        row[column] = change(row[column])

    edit_rows(plain_copy, damage)
    faults = faults_of(plain_copy)
    named = files(faults)
    if (
        column == "surface_x_m"
    ):  # against it stand two depth pictures: it cannot tell which is right
        assert any("truth.parquet" in str(fault) for fault in faults)
    else:
        assert f"{SEQ}/truth.parquet" in named


def test_a_table_without_a_column_or_with_nothing_in_it_is_named(plain_copy):
    path = plain_copy / SEQ / "truth.parquet"
    table = pq.read_table(path)
    pq.write_table(table.drop_columns(["qx"]), path)
    assert files(faults_of(plain_copy)) == [f"{SEQ}/truth.parquet"]
    pq.write_table(table.slice(0, 3), path)
    assert files(faults_of(plain_copy)) == [f"{SEQ}/truth.parquet"]
    path.write_bytes(b"PAR1")
    assert files(faults_of(plain_copy)) == [f"{SEQ}/truth.parquet"]


def test_a_wrong_count_of_an_object_is_named(copies):
    sequence = copies / "seq_000001"
    path = sequence / "objects.parquet"
    rows = pq.read_table(path).to_pylist()
    assert rows
    rows[0]["visible_left_px"] += 7
    pq.write_table(pa.Table.from_pylist(rows, schema=OBJECTS_SCHEMA), path)
    assert files(faults_of(copies)) == ["seq_000001/objects.parquet"]
