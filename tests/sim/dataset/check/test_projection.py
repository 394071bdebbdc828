"""Rigs that do not project the keypoints where the tables have them."""

from damaged_dataset import edit_json, faults_of, files

from pjpdaf.calibration import write_rig
from sim.dataset.stored_sequence import StoredSequence


def test_a_wrong_baseline_of_the_rig_is_named(copies):
    """In the calibration's files as well, so that they agree with it."""

    def longer(record):
        for key in ("cameras", "calibration"):
            record[key]["right"]["t_cw"][0] *= 1.02

    names = ["seq_000000", "seq_000001", "seq_000002"]
    for name in names:
        edit_json(copies / name / "rig.json", longer)
        sequence = StoredSequence(copies / name, {})
        write_rig(sequence.calibration, copies / name / "calib")
        write_rig(sequence.rig, copies / name / "calib" / "error_free")
    faults = faults_of(copies)
    assert [f"{name}/rig.json" for name in names[:2]] == files(faults)[:2]
    assert all("px off" in fault.text for fault in faults if fault.file.endswith("rig.json"))
    # With shutter skew it cannot be told by keypoints; the disparity does not fit the depth then.
    assert any(file.startswith(names[2]) for file in files(faults))
