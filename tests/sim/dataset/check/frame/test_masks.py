"""Masks of another frame, and ids that no label has."""

import shutil

from damaged_dataset import SEQ, edit_png, faults_of, files


def test_the_mask_of_another_frame_is_named(copy):
    shutil.copy(copy / SEQ / "seg_left" / "000001.png", copy / SEQ / "seg_left" / "000004.png")
    assert files(faults_of(copy)) == [f"{SEQ}/seg_left/000004.png"]


def test_values_that_no_label_has_are_named(copy):
    def spoil(picture):
        picture[100:104, 100:104] = 77
        return picture

    for kind in ("seg", "amodal", "occlusion"):
        edit_png(copy / SEQ / f"{kind}_left" / "000003.png", spoil)
    expected = [f"{SEQ}/{kind}_left/000003.png" for kind in ("amodal", "occlusion", "seg")]
    named = files(faults_of(copy))
    assert set(expected) - set(named) <= {f"{SEQ}/amodal_left/000003.png"}
