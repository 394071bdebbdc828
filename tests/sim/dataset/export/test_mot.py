"""MOTChallenge's files, read by motmetrics and TrackEval."""

import configparser
import os
from pathlib import Path

import cv2
import motmetrics
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from trackeval.datasets import MotChallenge2DBox
from trackeval.metrics import CLEAR, HOTA

import sim.dataset
from pjpdaf.targets import TARGETS
from sim.dataset.export.mot import export
from sim.scene.world import CAMERAS


@pytest.fixture(scope="module")
def mot(dataset, tmp_path_factory):
    into = tmp_path_factory.mktemp("exported")
    export(dataset, into)
    return into / "mot"


def sequences(mot):
    header, *names = (mot / "seqmaps" / "all.txt").read_text().splitlines()
    assert header == "name"
    return names


def test_seqinfo_leads_to_the_pictures(dataset, mot):
    """As its readers do: the picture of frame 1 is imDir/000001 + imExt."""
    names = sequences(mot)
    assert names == [f"{one.name}-{c}" for one in dataset.sequences for c in CAMERAS]
    for name in names:
        info = configparser.ConfigParser()
        info.read(mot / name / "seqinfo.ini")
        said = info["Sequence"]
        assert said["name"] == name
        # The export belongs beside the sequences; here it lies elsewhere.
        where = os.path.normpath(dataset.folder / "mot" / name / said["imDir"])
        pictures = sorted(Path(where).iterdir())
        assert len(pictures) == int(said["seqLength"])
        assert pictures[0].name == "000001" + said["imExt"]
        height, width = cv2.imread(str(pictures[0])).shape[:2]
        assert (width, height) == (int(said["imWidth"]), int(said["imHeight"]))
        assert int(said["frameRate"]) == 3


# motmetrics' own, with pandas 3.
@pytest.mark.filterwarnings("ignore:Operation with tuple is deprecated")
def test_motmetrics_reads_the_boxes_of_the_truth(dataset, mot):
    for sequence in dataset.sequences:
        for view, camera in enumerate(CAMERAS):
            path = mot / f"{sequence.name}-{camera}" / "gt" / "gt.txt"
            read = motmetrics.io.loadtxt(path, fmt="mot16", min_confidence=1)
            assert set(read["ClassId"]) == {1}
            wanted = {
                (truth.index + 1, target + 1): (box, truth.views[view].visible_fractions[target])
                for truth in sequence.truths
                for target, box in enumerate(truth.views[view].boxes_px)
                if np.isfinite(box).all()
            }
            assert set(read.index) == set(wanted)
            for at, row in read.iterrows():
                box, fraction = wanted[at]
                # motmetrics takes the 1 of MOTChallenge's corners off again.
                assert row[["X", "Y", "Width", "Height"]].tolist() == box.tolist()
                assert row["Visibility"] == pytest.approx(fraction, abs=1e-6)


def test_the_third_dimension_is_that_of_the_truth(dataset, mot):
    for sequence in dataset.sequences:
        path = mot / f"{sequence.name}-left" / "gt" / "gt_3d.txt"
        lines = np.loadtxt(path, delimiter=",", ndmin=2)
        assert lines.shape == (len(TARGETS) * sequence.frame_count, 10)
        for truth in sequence.truths:
            mine = lines[lines[:, 0] == truth.index + 1]
            assert mine[:, 1].tolist() == [1, 2, 3]
            np.testing.assert_allclose(mine[:, 7:], truth.centres_m, atol=6e-7)
            shown = truth.views[0].visible_px > 0
            np.testing.assert_array_equal(mine[:, 6], shown)
            corners = np.where(shown[:, None], truth.views[0].boxes_px + np.array([1, 1, 0, 0]), -1)
            np.testing.assert_array_equal(mine[:, 2:6], corners)


def scores(mot, folder, change):
    """HOTA and MOTA of the ground truth, changed line by line, as a tracker's answer."""
    answers = folder / "trackers" / "truth" / "data"
    answers.mkdir(parents=True)
    for name in sequences(mot):
        lines = np.loadtxt(mot / name / "gt" / "gt.txt", delimiter=",", ndmin=2)
        np.savetxt(answers / f"{name}.txt", change(lines), fmt="%g", delimiter=",")
    data = MotChallenge2DBox(
        {
            "GT_FOLDER": str(mot),
            "TRACKERS_FOLDER": str(folder / "trackers"),
            "SEQMAP_FILE": str(mot / "seqmaps" / "all.txt"),
            "SKIP_SPLIT_FOL": True,
            "PRINT_CONFIG": False,
        }
    )
    found = []
    for name in data.seq_list:
        raw = data.get_raw_seq_data("truth", name)
        ready = data.get_preprocessed_seq_data(raw, "pedestrian")
        assert ready["num_gt_dets"] > 0
        hota = HOTA().eval_sequence(ready)["HOTA"].mean()
        found.append((hota, CLEAR({"PRINT_CONFIG": False}).eval_sequence(ready)["MOTA"]))
    assert len(found) == len(sequences(mot))
    return np.array(found)


def test_trackeval_scores_the_truth_against_itself_one(mot, tmp_path):
    np.testing.assert_allclose(scores(mot, tmp_path, lambda lines: lines), 1.0, atol=1e-12)


def test_trackeval_sees_a_moved_box_and_another_id(mot, tmp_path):
    moved = scores(mot, tmp_path / "moved", lambda lines: lines + np.eye(9)[2] * 10)
    assert (moved[:, 0] < 0.95).all()

    def swap_in_half(lines):
        late = lines[:, 0] > lines[-1, 0] // 2
        swapped = lines.copy()
        swapped[late, 1] = 4 - lines[late, 1]
        return swapped

    assert (scores(mot, tmp_path / "swapped", swap_in_half)[:, 0] < 0.95).all()


def test_a_lost_picture_has_no_boxes(dataset_copy, tmp_path):
    path = dataset_copy / "seq_000000" / "truth.parquet"
    table = pq.read_table(path)
    came = [row["frame_index"] != 2 for row in table.select(["frame_index"]).to_pylist()]
    column = table.schema.get_field_index("arrived_right")
    pq.write_table(table.set_column(column, "arrived_right", pa.array(came)), path)
    export(sim.dataset.open(dataset_copy), tmp_path)
    for camera, shown in (("left", 1), ("right", 0)):
        folder = tmp_path / "mot" / f"seq_000000-{camera}" / "gt"
        boxes = np.loadtxt(folder / "gt.txt", delimiter=",")
        assert (3 in boxes[:, 0]) == bool(shown)
        places = np.loadtxt(folder / "gt_3d.txt", delimiter=",")
        third = places[places[:, 0] == 3]
        assert third[:, 6].tolist() == [shown] * 3
        assert (third[:, 2:6] == -1).all() == (not shown)
