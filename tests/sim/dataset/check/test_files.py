"""Missing, superfluous, repeated and damaged files."""

import shutil

from damaged_dataset import SEQ, faults_of, files

from sim.dataset.check.fault import Fault
from sim.dataset.verify import verify


def test_a_flipped_byte_is_named(plain_copy):
    path = plain_copy / SEQ / "left" / "000002.png"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    faults = verify(plain_copy)
    assert files(faults) == [f"{SEQ}/left/000002.png"]
    assert any("SHA-256" in fault.text for fault in faults)


def test_a_damaged_picture_is_named_without_its_checksum(plain_copy):
    path = plain_copy / SEQ / "seg_left" / "000002.png"
    path.write_bytes(path.read_bytes()[:100])
    assert files(faults_of(plain_copy)) == [f"{SEQ}/seg_left/000002.png"]


def test_a_missing_picture_is_one_line(plain_copy):
    (plain_copy / SEQ / "right" / "000003.png").unlink()
    expected = [Fault(f"{SEQ}/right/000003.png", "missing")]
    assert verify(plain_copy) == expected
    assert faults_of(plain_copy) == expected
    assert str(expected[0]) == "seq_000000/right/000003.png: missing"


def test_any_missing_file_is_named(copy):
    names = [
        "amodal_right/000001.png",
        "background_left/000001.png",
        "calib/error_free/intrinsics.yml",
        "calib/extrinsics.yml",
        "correspondence_left/000005.png",
        "events.json",
        "objects.parquet",
        "occlusion_right/000004.png",
        "recipe.json",
    ]
    for name in names:
        (copy / SEQ / name).unlink()
    expected = [Fault(f"{SEQ}/{name}", "missing") for name in names]
    assert faults_of(copy) == expected
    for name in ("truth.parquet", "rig.json"):
        (copy / SEQ / name).unlink()
        assert Fault(f"{SEQ}/{name}", "missing") in faults_of(copy)


def test_a_missing_sequence_is_named(copies):
    shutil.rmtree(copies / "seq_000001")
    assert faults_of(copies) == [Fault("seq_000001", "missing")]


def test_a_file_that_nobody_lists_is_named(plain_copy):
    (plain_copy / SEQ / "left" / "stray.txt").write_text("?")
    assert files(verify(plain_copy)) == [f"{SEQ}/left/stray.txt"]
    (plain_copy / "stray.bin").write_text("?")
    assert "stray.bin" in files(verify(plain_copy))


def test_a_picture_of_no_frame_is_named(plain_copy):
    shutil.copy(plain_copy / SEQ / "left" / "000001.png", plain_copy / SEQ / "left" / "000009.png")
    assert files(faults_of(plain_copy)) == [f"{SEQ}/left/000009.png"]


def test_a_picture_of_another_frame_byte_for_byte_is_named(plain_copy):
    shutil.copy(plain_copy / SEQ / "left" / "000001.png", plain_copy / SEQ / "left" / "000005.png")
    assert files(faults_of(plain_copy)) == [f"{SEQ}/left/000005.png"]


def test_a_link_is_named_and_not_followed(plain_copy, tmp_path):
    outside = tmp_path / "outside.png"
    path = plain_copy / SEQ / "left" / "000001.png"
    shutil.move(path, outside)
    path.symlink_to(outside)
    faults = verify(plain_copy)
    assert files(faults) == [f"{SEQ}/left/000001.png"]
    assert any("link" in fault.text for fault in faults)
