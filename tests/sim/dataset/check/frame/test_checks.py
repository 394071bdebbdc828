"""Labels of another view or frame."""

import shutil

import pytest
from damaged_dataset import SEQ, exchange, faults_of, files


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "kind",
    [
        *("depth", "seg", "amodal", "disparity", "correspondence", "float"),
        *("semantic", "normals"),
    ],
)
def test_exchanged_labels_are_named(copy, kind):
    exchange(copy / SEQ / f"{kind}_left", copy / SEQ / f"{kind}_right")
    suffix = "npz" if kind == "float" else "png"
    named = files(faults_of(copy))
    for frame in range(1, 6):
        assert any(f"/{kind}_" in file and file.endswith(f"{frame:06d}.{suffix}") for file in named)


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", ["depth", "amodal", "disparity", "semantic", "normals"])
def test_a_label_of_another_frame_is_named(copy, kind):
    folder = copy / SEQ / f"{kind}_right"
    shutil.copy(folder / "000001.png", folder / "000005.png")
    assert f"{SEQ}/{kind}_right/000005.png" in files(faults_of(copy))
