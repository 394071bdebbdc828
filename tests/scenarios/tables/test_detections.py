"""Files of anyone's 2-D detections, for `--detections`."""

import cv2
import numpy as np
import pandas as pd
import pytest
from commands import assert_one_line, in_this_process
from made_dataset import made_dataset

import sim.dataset
from pjpdaf.calibration import write_rig
from pjpdaf.camera import Camera, StereoRig, project
from pjpdaf.detector.external import DEFAULT_SD_PX
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from scenarios.tables.detections import EVIDENCE, read_detections

K = np.array([[540.0, 0.0, 319.5], [0.0, 540.0, 239.5], [0.0, 0.0, 1.0]])
CAMERA = Camera(K, np.eye(3), np.zeros(3), 640, 480, np.zeros(0))
HEADER = "frame,view,u_px,v_px"


def read(path, min_score=0.0, frames=10):
    tables = read_detections(path, {"a": (CAMERA, CAMERA)}, {"a": frames}, min_score)
    return tables["a"]


def write(folder, text):
    path = folder / "detections.csv"
    path.write_text(text)
    return path


def test_a_name_in_the_sequence_column_of_one_sequence_is_told_how_to_go(tmp_path):
    path = write(tmp_path, f"sequence,{HEADER}\nseq_000000,0,left,1,2\n")
    one = {"footage": (CAMERA, CAMERA)}
    with pytest.raises(BenchError) as caught:
        read_detections(path, one, {"footage": None}, whole="the footage")
    assert str(caught.value) == (
        f"{path}:2: no sequence 'seq_000000' in the footage; it is one sequence, footage: leave "
        "the column `sequence` out"
    )


def test_rows_come_by_view_and_sorted_by_frame(tmp_path):
    text = f"{HEADER},sd_px,area_px\n5,left,10,20,,\n3,0,1,2,1.5,900\n3,right,7,8,,\n3,left,3,4,,\n"
    left, right = read(write(tmp_path, text))
    np.testing.assert_array_equal(left.frames, [3, 3, 5])
    np.testing.assert_array_equal(left.centres_px, [[1, 2], [3, 4], [10, 20]])
    np.testing.assert_array_equal(left.sd_px, [1.5, DEFAULT_SD_PX, DEFAULT_SD_PX])
    np.testing.assert_array_equal(left.areas_px, [900, np.nan, np.nan])
    np.testing.assert_array_equal(right.centres_px, [[7, 8]])
    assert left.evidence is None


def test_parquet_gives_what_csv_gives(tmp_path):
    rows = {
        "frame": [0, 1],
        "view": ["left", "left"],
        "u_px": [1.5, 2.5],
        "v_px": [3.0, 4.0],
        "score": [0.9, 0.2],
        EVIDENCE[0]: [0.0, -3.0],
        EVIDENCE[1]: [-3.0, 0.0],
        EVIDENCE[2]: [-3.0, -1.0],
    }
    frame = pd.DataFrame(rows)
    frame.to_csv(tmp_path / "d.csv", index=False)
    frame.to_parquet(tmp_path / "d.parquet")
    for one, two in zip(read(tmp_path / "d.csv"), read(tmp_path / "d.parquet"), strict=True):
        np.testing.assert_array_equal(one.centres_px, two.centres_px)
        np.testing.assert_array_equal(one.evidence, two.evidence)
    left, _ = read(tmp_path / "d.csv", min_score=0.5)
    np.testing.assert_array_equal(left.frames, [0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frame,view,u_px\n", r":1: lacks the column v_px; there are: frame, view, u_px"),
        (f"{HEADER}\n1,middle,1,2\n", r":2: view must be left or right \(or 0, 1\), got 'middle'"),
        (f"{HEADER}\n1,left,,2\n", r":2: u_px is empty; a detection needs a place"),
        (f"{HEADER}\n1,left,1,nan\n", r":2: v_px is nan"),
        (f"{HEADER}\n10,left,1,2\n", r":2: frame 10 is not in the sequence: its 10 frames"),
        (f"{HEADER}\n1.5,left,1,2\n", r":2: frame must be a whole number, got '1.5'"),
        (f"{HEADER}\n1,left,5000,2\n", r":2: u_px is 5000, far outside the picture of 640 pixels"),
        (f"{HEADER},sd_px\n1,left,1,2,0\n", r":2: sd_px must be above 0, got 0"),
        (f"{HEADER},score\n1,left,1,2,7\n", r":2: score must be between 0 and 1, got 7"),
        (f"{HEADER},evidence_head\n1,left,1,2,0\n", r":2: has evidence_head but not all of"),
    ],
)
def test_a_wrong_file_is_one_line_with_its_place(tmp_path, text, message):
    with pytest.raises(BenchError, match=message) as fault:
        read(write(tmp_path, text))
    assert "\n" not in str(fault.value)


def evidence_of(target):
    return [0.0 if other == target else -3.0 for other in TARGETS]


def test_true_centres_as_detections_give_true_tracks(tmp_path, tmp_path_factory):
    """The default tracker over another detector, the truth: its own error is all that is left."""
    folder = made_dataset(tmp_path_factory)
    rows = []
    for sequence in sim.dataset.open(folder).sequences:
        for _, truth in sequence.frames():
            for view, camera in zip(("left", "right"), sequence.rig.cameras, strict=True):
                for target, (u, v) in zip(TARGETS, project(camera, truth.centres_m), strict=True):
                    place = [sequence.folder.name, truth.index, view, u, v]
                    rows.append([*place, 0.3, *evidence_of(target)])
    columns = ["sequence", *HEADER.split(","), "sd_px", *EVIDENCE]
    pd.DataFrame(rows, columns=columns).to_csv(tmp_path / "d.csv", index=False)
    words = ("run", "--from", folder, "--preset", "default", "--jobs", 1, "--slim")
    done = in_this_process(*words, "--detections", tmp_path / "d.csv", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    episodes = pd.read_parquet(tmp_path / "run" / "episodes.parquet")
    assert (episodes["within_100"] == episodes["frames"]).all()
    hands = episodes[episodes["target"].isin(["right_hand", "left_hand"])]
    assert hands["median_error_mm"].max() < 40  # 96 x 72 pixels: one is 60 mm of depth
    meta = (tmp_path / "run" / "run.json").read_text()
    assert '"detector": "d.csv"' in meta


def test_options_that_do_not_go_together_are_one_line(tmp_path):
    file = write(tmp_path, f"{HEADER}\n1,left,1,2\n")
    done = in_this_process("run", "cross", "--detections", file, "--out", tmp_path / "x")
    assert_one_line(done, 2, "--detections goes with --from DATASET")
    done = in_this_process("run", "--detections", file, "--detector", "thesis")
    assert_one_line(done, 2, "--detections takes the place of --detector: give one of them")


def footage(folder):
    """Grey pictures, two cameras 90 mm apart, and detections of head and hands that stand still."""
    right = Camera(K, np.eye(3), np.array([-0.09, 0.0, 0.0]), 640, 480, np.zeros(0))
    write_rig(StereoRig(CAMERA, right), folder / "cal")
    points = np.array([[0.0, -0.3, 1.4], [-0.2, 0.05, 1.2], [0.2, 0.05, 1.2]])
    rows = []
    for view, camera in (("left", CAMERA), ("right", right)):
        (folder / view).mkdir()
        for frame in range(6):
            picture = np.full((480, 640, 3), 90, np.uint8)
            assert cv2.imwrite(str(folder / view / f"{frame:03d}.png"), picture)
            for target, (u, v) in zip(TARGETS, project(camera, points), strict=True):
                rows.append([frame, view, u, v, *evidence_of(target)])
    columns = [*HEADER.split(","), *EVIDENCE]
    pd.DataFrame(rows, columns=columns).to_csv(folder / "d.csv", index=False)
    return points


def test_track_follows_detections_in_footage_without_a_background(tmp_path):
    points = footage(tmp_path)
    words = ["track", "--left", tmp_path / "left", "--right", tmp_path / "right"]
    words += ["--calibration", tmp_path / "cal/intrinsics.yml", tmp_path / "cal/extrinsics.yml"]
    words += ["--preset", "default", "--detections", tmp_path / "d.csv"]
    done = in_this_process(*words, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    tracks = pd.read_csv(tmp_path / "out" / "tracks.csv")
    last = tracks[tracks["frame"] == 5]
    assert list(last["target"]) == list(TARGETS)
    assert list(last["status"]) == ["tracked"] * 3
    places = last[["x_m", "y_m", "z_m"]].to_numpy()
    # The head's offset from visible skin to centre is the tracker's, for skin detections.
    assert np.linalg.norm(places - points, axis=1).max() < 0.06
    done = in_this_process(*words, "--background-first", 3, "--out", tmp_path / "o2")
    assert_one_line(done, 2, "--background-first: detections come from")
