"""Left and right pictures that are swapped."""

import shutil

from damaged_dataset import SEQ, edit_rows, exchange, faults_of, files

from sim.dataset.reader import open_dataset


def test_exchanged_eyes_are_named(copies):
    """Dark and near skin, through a lens, with shutter skew; lost pictures need not be."""
    expected = set()
    for sequence in open_dataset(copies).sequences:
        exchange(sequence.folder / "left", sequence.folder / "right")
        rows = sequence.truth.iloc[::3]
        for index in rows[rows.arrived_left & rows.arrived_right].frame_index:
            expected |= {f"{sequence.name}/{c}/{index + 1:06d}.png" for c in ("left", "right")}
    assert len(expected) > 16
    assert expected <= set(files(faults_of(copies)))


def test_one_exchanged_pair_is_named(copy):
    exchange(copy / SEQ / "left" / "000004.png", copy / SEQ / "right" / "000004.png")
    faults = faults_of(copy)
    assert files(faults) == [f"{SEQ}/left/000004.png", f"{SEQ}/right/000004.png"]
    assert faults[0].text == "is a picture of the right camera"


def test_exchanged_backgrounds_are_named(copy):
    exchange(copy / SEQ / "background_left", copy / SEQ / "background_right")
    assert files(faults_of(copy)) == [f"{SEQ}/background_{c}/000001.png" for c in ("left", "right")]


def test_exchanged_clean_pictures_are_named(copy):
    exchange(copy / SEQ / "clean_left" / "000002.png", copy / SEQ / "clean_right" / "000002.png")
    assert files(faults_of(copy)) == [f"{SEQ}/clean_{c}/000002.png" for c in ("left", "right")]


def test_a_lone_picture_of_the_wrong_eye_is_named(copy):
    """Its other eye is lost, so that only the background tells."""
    folder = copy / SEQ
    shutil.move(folder / "right" / "000002.png", folder / "left" / "000002.png")

    def lose(row):
        row["arrived_right"] &= row["frame_index"] != 1

    edit_rows(copy, lose)
    assert f"{SEQ}/left/000002.png" in files(faults_of(copy))
