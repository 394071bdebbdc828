"""Disparity of another scale."""

from damaged_dataset import edit_png, faults_of, files


def test_a_disparity_of_another_scale_is_named(copies):
    """Of a rig that is not parallel, whose rectified pair has pixels of its own."""
    edit_png(copies / "seq_000001" / "disparity_left" / "000002.png", lambda d: d // 2)
    named = files(faults_of(copies))
    assert "seq_000001/disparity_left/000002.png" in named
    assert not any("depth" in file for file in named)
