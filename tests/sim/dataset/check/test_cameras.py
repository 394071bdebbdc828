"""Damaged rigs and calibrations."""

import pytest
from damaged_dataset import SEQ, edit_json, edit_yml, faults_of, files

from sim.dataset.verify import verify


@pytest.mark.parametrize("folder", ["calib", "calib/error_free"])
def test_a_wrong_baseline_in_the_calibration_is_named(plain_copy, folder):
    path = plain_copy / SEQ / folder / "extrinsics.yml"
    edit_yml(path, "T", 0, 1e-4)
    faults = faults_of(plain_copy)
    assert files(faults) == [f"{SEQ}/{folder}/extrinsics.yml"]
    assert any(fault.text.startswith("T differs from") for fault in faults)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("key", "file"),
    [("R", "extrinsics"), ("P2", "extrinsics"), ("Q", "extrinsics"), ("D1", "intrinsics")],
)
def test_a_wrong_matrix_of_the_calibration_is_named(plain_copy, key, file):
    path = plain_copy / SEQ / "calib" / f"{file}.yml"
    edit_yml(path, key, 1, 1e-3)
    assert f"{SEQ}/calib/{file}.yml" in files(faults_of(plain_copy))


@pytest.mark.parametrize("place", ["rig.json", "calib/intrinsics.yml"])
def test_a_shifted_principal_point_is_named(plain_copy, place):
    path = plain_copy / SEQ / place
    if place == "rig.json":

        def shift(record):
            for key in ("cameras", "calibration"):
                record[key]["left"]["K"][0][2] += 0.5

        edit_json(path, shift)
    else:
        edit_yml(path, "M1", 2, 0.5)
    assert f"{SEQ}/{place}" in files(faults_of(plain_copy))


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r["cameras"]["left"].update(K=[[0, 0, 0]] * 3),
        lambda r: r["cameras"]["right"].update(R_cw=[[2, 0, 0], [0, 1, 0], [0, 0, 1]]),
        lambda r: r["cameras"]["right"].update(distortion=[9.0, 9.0, 9.0, 9.0]),
        lambda r: r["cameras"].update(right=r["cameras"]["left"]),
        lambda r: r.update(frames=10_000_000),
        lambda r: r.update(fps=None),
        lambda r: r.update(cameras=[]),
        lambda r: r.update(instances=[{"id": "x"}]),
        lambda r: r.pop("skew_s"),
    ],
)
def test_a_damaged_rig_is_named_and_nothing_is_raised(plain_copy, change):
    edit_json(plain_copy / SEQ / "rig.json", change)
    named = files(verify(plain_copy, sums=False))
    assert f"{SEQ}/rig.json" in named or f"{SEQ}/truth.parquet" in named
