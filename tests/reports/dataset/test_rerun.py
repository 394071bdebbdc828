"""A data set as a recording for Rerun."""

import pytest

from reports.dataset.rerun import write_dataset_rerun
from sim.scene.world import CAMERAS


@pytest.fixture(scope="module")
def dataset(labelled):
    return labelled


def test_a_recording_has_the_labels_under_their_names(dataset, tmp_path):
    pytest.importorskip("rerun", reason="needs the extra viz")
    chunks = pytest.importorskip("rerun.chunk", reason="this Rerun cannot read its own files")
    file = write_dataset_rerun(dataset, dataset.sequences, tmp_path / "out.rrd")
    rows = {}
    for chunk in chunks.RrdReader(file).stream():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.num_rows
    for view in CAMERAS:
        for what in ("picture", "seg", "depth", "boxes/head", "keypoints/left_hand"):
            assert rows[f"/seq_000000/cameras/{view}/{what}"] == 20, what
        # The viewer knows no lens.
        assert f"/seq_000001/cameras/{view}/depth" not in rows
    assert rows["/seq_000001/truth/right_hand"] == 5
