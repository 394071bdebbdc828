"""Damaged HDF5 files, and files that lead elsewhere."""

import shutil

import numpy as np
import pytest
from damaged_dataset import SEQ, faults_of, files
from shared import copied

from sim.dataset.export.hdf5 import export
from sim.dataset.reader import open_dataset

h5py = pytest.importorskip("h5py")
FILE = f"hdf5/{SEQ}.h5"


@pytest.fixture(scope="module")
def exported(plain, tmp_path_factory):
    """`plain` with HDF5; read only."""
    folder = tmp_path_factory.mktemp("hdf5") / "set"
    shutil.copytree(plain, folder)
    export(open_dataset(folder), folder)
    return folder


copy = copied("exported")


def test_a_sound_copy_has_no_fault(copy):
    assert faults_of(copy) == []


def only_fault(copy):
    (fault,) = faults_of(copy)
    assert fault.file == FILE
    return fault.text


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("array", "frame", "text"),
    [
        ("truth/positions_m", 3, "is not that of the tables, first in frame 3"),
        ("truth/boxes_right_px", 2, "is not that of the tables, first in frame 2"),
        ("truth/arrived", 4, "is not that of the tables, first in frame 4"),
        ("pictures/left", 0, "is not the picture of frame 0"),
        ("labels/depth_right", 0, "is not the picture of frame 0"),
    ],
)
def test_numbers_and_pictures_of_something_else_are_named(copy, array, frame, text):
    with h5py.File(copy / FILE, "r+") as file:
        file[array][frame] = file[array][frame] + 1
    assert only_fault(copy) == f"{array} {text}"


def test_an_array_of_another_shape_or_none_is_named(copy):
    with h5py.File(copy / FILE, "r+") as file:
        del file["truth/stamp_s"], file["labels/seg_left"]
        file["labels/seg_left"] = np.zeros((1 << 20, 1 << 10), np.uint8)[:2]
    texts = [fault.text for fault in faults_of(copy)]
    assert texts == [
        "labels/seg_left is not an array of 5 pictures 192x144 in the file",
        "truth/stamp_s is not an array (5,) in the file",
    ]


@pytest.mark.parametrize("way", ["external file", "external link", "virtual", "soft link"])
def test_an_array_that_lies_in_another_file_is_not_read(copy, tmp_path, way):
    elsewhere = tmp_path / "elsewhere"
    with h5py.File(copy / FILE, "r+") as file:
        values = file["truth/stamp_s"][...]
        del file["truth/stamp_s"]
        if way == "external file":
            elsewhere.write_bytes(values.tobytes())
            file.create_dataset(
                "truth/stamp_s", values.shape, values.dtype, external=[(str(elsewhere), 0, 40)]
            )
        else:
            with h5py.File(elsewhere, "w") as other:
                other["stamp_s"] = values
            if way == "external link":
                file["truth/stamp_s"] = h5py.ExternalLink(elsewhere, "stamp_s")
            elif way == "virtual":
                layout = h5py.VirtualLayout(values.shape, values.dtype)
                layout[:] = h5py.VirtualSource(elsewhere, "stamp_s", values.shape)
                file.create_virtual_dataset("truth/stamp_s", layout)
            else:
                file["truth/stamp_s"] = h5py.SoftLink("/truth/time_s")
    assert only_fault(copy) == "truth/stamp_s is not an array (5,) in the file"


def test_a_file_that_is_cut_short_or_missing_is_named(copy):
    path = copy / FILE
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert only_fault(copy).startswith("is a damaged HDF5 file: ")
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(4000))
    assert only_fault(copy).startswith("is a damaged HDF5 file: ")
    path.rename(path.with_name("other.h5"))
    assert files(faults_of(copy))[-1] == FILE
