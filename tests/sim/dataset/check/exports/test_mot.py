"""Damaged MOTChallenge files."""

import pytest
from damaged_dataset import SEQ, faults_of, files


def test_mot_boxes_that_count_from_0_are_named(plain_copy):
    path = plain_copy / "mot" / f"{SEQ}-left" / "gt" / "gt.txt"
    lines = [line.split(",") for line in path.read_text().splitlines()]
    path.write_text("".join(f"{f},{i},{int(x) - 1},{','.join(r)}\n" for f, i, x, *r in lines))
    faults = faults_of(plain_copy)
    assert files(faults) == [f"mot/{SEQ}-left/gt/gt.txt"]
    assert "counted from 1" in faults[0].text


@pytest.mark.parametrize("name", ["gt/gt.txt", "gt/gt_3d.txt", "seqinfo.ini"])
def test_damaged_mot_files_are_named(plain_copy, name):
    path = plain_copy / "mot" / f"{SEQ}-right" / name
    path.write_text(path.read_text().replace("1", "2", 1))
    assert files(faults_of(plain_copy)) == [f"mot/{SEQ}-right/{name}"]
