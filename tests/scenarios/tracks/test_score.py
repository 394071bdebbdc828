"""`score`: anyone's tracks against a data set's truth, from CSV and Parquet files."""

import json
import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from commands import in_this_process

import sim.dataset
from pjpdaf.camera import to_camera
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.footage.tracks import TrackWriter
from reports.gate.gate import compare
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.run.tables import tables_of
from scenarios.play.plan import plan
from scenarios.play.play import play_complete
from scenarios.run.save_run import scenario_record
from scenarios.tracks.files import read_tracks
from scenarios.tracks.score import ScoreRequest, score_tracks
from tests.scenarios.play.test_from_dataset import JOBS, ROOT, made_of_jobs, request

HEADER = "sequence,frame,target,x_m,y_m,z_m"
COUNTS = {"seq_000000": 5, "seq_000001": 4}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_of_jobs(tmp_path_factory)


@pytest.fixture(scope="module")
def episodes(made):
    return [play_complete(one) for one in plan(request(made))]


@pytest.fixture(scope="module")
def truth(made):
    """The perfect tracks, as a table."""
    rows = [
        (sequence.name, truth.index, target, *centre)
        for sequence in sim.dataset.open(made).sequences
        for truth in sequence.truths
        for target, centre in zip(TARGETS, truth.centres_m.tolist(), strict=True)
    ]
    return pd.DataFrame(rows, columns=HEADER.split(","))


def scored(made, tracks, tmp_path, **changes):
    score_tracks(ScoreRequest(made, tracks, tmp_path / "scored", **changes))
    return load(tmp_path / "scored")


def written(table, path):
    if path.suffix == ".csv":
        table.to_csv(path, index=False)
    else:
        table.to_parquet(path)
    return path


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["t.csv", "t.parquet"])
def test_perfect_tracks_have_no_error(made, truth, tmp_path, name, capsys):
    saved = scored(made, written(truth, tmp_path / name), tmp_path)
    assert len(saved.frames) == 3 * (5 + 4)
    assert (saved.frames["error_mm"] == 0).all()
    assert (saved.frames["status"] == "tracked").all()
    assert saved.events.empty
    assert (saved.tracking["sum_gospa_mm"] == 0).all()
    assert {p["scenario"] for p in saved.meta["pictures"]} == {"cross", "cross+noise"}
    assert (tmp_path / "scored/report.html").stat().st_size > 100_000
    said = capsys.readouterr().out
    assert "2 sequences, 9 stereo frames scored" in said
    assert "note:" not in said


def files_of(episodes, folder):
    """The tracker's own estimates in the world, one file a sequence, by the writer of `track`."""
    for number, episode in enumerate(episodes):
        target = folder / f"seq_{number:06d}"
        target.mkdir(parents=True)
        with closing(TrackWriter(target, episode.cameras)) as tracks:
            for outcome in episode.frames:
                truth = outcome.truth
                tracks.add(truth.index, truth.time_s, outcome.estimates)
    return folder


SCORES = ["error_mm", "lateral_mm", "depth_mm", "surface_mm", "err_acc_px", "error_left_px"]


def test_the_trackers_own_estimates_score_as_its_run(made, episodes, tmp_path):
    rows = [rows_of(episode) for episode in episodes]
    run = tables_of(rows)["frames"].to_pandas()
    table = run.assign(
        sequence=run["scenario"].map({"cross": "seq_000000", "cross+noise": "seq_000001"})
    ).rename(columns={f"estimate_{axis}_m": f"{axis}_m" for axis in "xyz"})
    tracks = written(table[[*HEADER.split(","), "status"]], tmp_path / "own.csv")
    saved = scored(made, tracks, tmp_path)
    np.testing.assert_allclose(saved.frames[SCORES], run[SCORES], rtol=0, atol=1e-3)
    for column in ("error_mm", "status", "merged", "visible_left", "labels"):
        assert saved.frames[column].equals(run[column]), column
    entries = {one.name: scenario_record(one) for one in JOBS}
    base = load(save(tmp_path / "run", rows, RunInfo("run", entries=entries)))
    verdict = compare(base, saved)
    assert verdict.verdict == "pass"
    assert all(metric.difference.mean == 0 for metric in verdict.metrics)
    assert base.meta["scenarios"] == saved.meta["scenarios"]
    assert base.episodes["values_json"].equals(saved.episodes["values_json"])


def test_files_as_track_writes_them_are_read(made, episodes, tmp_path):
    run = tables_of([rows_of(episode) for episode in episodes])["frames"].to_pandas()
    saved = scored(made, files_of(episodes, tmp_path / "tracks"), tmp_path)
    # Six digits are written: half a micrometre an axis.
    np.testing.assert_allclose(
        saved.frames["error_mm"], run["error_mm"], rtol=0, atol=1e-3 * 0.5 * 3**0.5
    )
    assert saved.frames["status"].equals(run["status"])
    known = run["covariance_xx_m2"].notna()
    np.testing.assert_allclose(
        saved.frames["covariance_xx_m2"][known], run["covariance_xx_m2"][known], rtol=1e-3
    )


def test_stated_exchange_probabilities_are_scored(made, episodes, tmp_path):
    stated = [
        replace(
            episode,
            frames=tuple(
                replace(o, estimates=replace(o.estimates, exchange_probability=f / 8))
                for f, o in enumerate(episode.frames)
            ),
        )
        for episode in episodes
    ]
    run = tables_of([rows_of(episode) for episode in stated])
    saved = scored(made, files_of(stated, tmp_path / "tracks"), tmp_path)
    frames = run["frames"].to_pandas()
    assert saved.frames["exchange_probability"].equals(frames["exchange_probability"])
    assert frames["exchange_probability"].notna().sum() == 2 * len(frames) // 3
    counts = ["exchange_frames", "exchanged_frames", "sum_exchange_probability"]
    assert saved.episodes[counts].equals(run["episodes"].to_pandas()[counts])


def test_the_verb_track_on_its_pictures_scores_as_the_run(made, episodes, tmp_path):
    """Real files all the way: calibration in YAML, pictures, tracks in the left camera's frame."""
    folder = made / "seq_000000"
    words = ["track", "--fps", 3, "--out", tmp_path / "tracks/seq_000000"]
    for view in ("left", "right"):
        words += [f"--{view}", folder / view, f"--background-{view}", folder / f"background_{view}"]
    words += ["--calibration", folder / "calib/intrinsics.yml", folder / "calib/extrinsics.yml"]
    done = in_this_process(*words)
    assert done.returncode == 0, done.stderr
    saved = scored(made, tmp_path / "tracks", tmp_path, frame="left")
    mine = saved.frames[saved.frames["scenario"] == "cross"]
    run = tables_of([rows_of(episodes[0])])["frames"].to_pandas()
    np.testing.assert_allclose(mine["error_mm"], run["error_mm"], atol=0.1)


@pytest.mark.long
def test_positions_in_the_left_cameras_frame(made, truth, tmp_path):
    """And standard deviations, turned with them: NEES is the same in any frame."""
    rng = np.random.default_rng(0)
    table = truth.copy()
    columns = ["x_m", "y_m", "z_m"]
    table[columns] += rng.normal(0, 0.02, (len(table), 3))
    for axis in "xyz":
        table[f"sd_{axis}_m"] = 0.02
    world = scored(made, written(table, tmp_path / "world.csv"), tmp_path / "world")
    for sequence in sim.dataset.open(made).sequences:
        mine = table["sequence"] == sequence.name
        points = table.loc[mine, columns].to_numpy()
        table.loc[mine, columns] = to_camera(sequence.calibration.left, points)
    left = scored(made, written(table, tmp_path / "left.csv"), tmp_path / "left", frame="left")
    for column in ("error_mm", "nees"):
        np.testing.assert_allclose(world.frames[column], left.frames[column], rtol=1e-6)
    assert 1 < world.frames["nees"].mean() < 6


def test_the_wrong_frame_is_hinted_at(made, truth, tmp_path, capsys):
    score_tracks(
        ScoreRequest(made, written(truth, tmp_path / "t.csv"), tmp_path / "out", frame="left")
    )
    assert "as --frame world the tracks would be much nearer" in capsys.readouterr().out


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(2))
def test_missing_rows_are_lost_and_all_else_stays(made, truth, tmp_path, seed):
    keep = np.random.default_rng(seed).random(len(truth)) < 0.5
    table = truth[keep].sample(frac=1, random_state=seed)  # in any order
    saved = scored(made, written(table, tmp_path / "t.csv"), tmp_path)
    there = saved.frames["error_mm"].notna()
    assert int(there.sum()) == int(keep.sum())
    assert set(saved.frames["status"][~there]) <= {"lost"}
    assert int(saved.episodes["covered"].sum()) == int(keep.sum())
    assert int(saved.episodes["frames"].sum()) == len(truth)


@pytest.mark.long
def test_a_sequence_without_tracks_is_lost_and_told(made, truth, tmp_path, capsys):
    table = truth[truth["sequence"] == "seq_000001"]
    saved = scored(made, written(table, tmp_path / "t.csv"), tmp_path)
    assert "seq_000000 (cross seed 101) has no tracks: all lost" in capsys.readouterr().out
    mine = saved.frames[saved.frames["scenario"] == "cross"]
    assert len(mine) == 3 * 5
    assert mine["error_mm"].isna().all()


@pytest.mark.long
def test_no_tracker_no_blame_no_budget(made, truth, tmp_path):
    table = truth.copy()
    hands = table["target"].map({"right_hand": "left_hand", "left_hand": "right_hand"})
    table["target"] = hands.fillna(table["target"])
    saved = scored(made, written(table, tmp_path / "swapped.csv"), tmp_path)
    assert "swap" in set(saved.events["kind"])
    assert set(saved.events["blame"]) == {""}
    assert (saved.episodes["budget_frames"] == 0).all()
    page = (tmp_path / "scored/report.html").read_text()
    assert 'class="blame"' not in page
    assert 'class="budget"' not in page


def test_an_older_recipe_does_not_keep_tracks_from_being_scored(made, truth, tmp_path, capsys):
    copy = Path(shutil.copytree(made, tmp_path / "copy"))
    for path in copy.glob("*/recipe.json"):
        path.write_text(json.dumps({**json.loads(path.read_text()), "schema": 0}))
    saved = scored(copy, written(truth, tmp_path / "t.csv"), tmp_path)
    assert (saved.frames["error_mm"] == 0).all()
    assert [one["digests"] for one in saved.meta["scenarios"]] == [
        [entry["digest"]] for entry in json.loads((copy / "manifest.json").read_text())["sequences"]
    ]
    assert "is not a recipe of version 1. Its drawn values are left out." in capsys.readouterr().out


# --- faults --------------------------------------------------------------------------------------


def lines(*rows, header=HEADER):
    return "\n".join((header, *rows)) + "\n"


GOOD = "seq_000000,0,head,0.1,0,1.2"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ":1: lacks the columns sequence, frame, target, x_m, y_m, z_m"),
        (lines(header="sequence,frame,target,x,y,z"), ":1: lacks the columns x_m, y_m, z_m"),
        (lines(header=HEADER + ",x_m"), ":1: has the column 'x_m' twice"),
        (lines(GOOD, "seq_9,0,head,0,0,1"), ":3: no sequence 'seq_9' in the data set"),
        (
            lines(GOOD, "seq_000000,5,head,0,0,1"),
            ":3: frame 5 is not in the sequence: its 5",
        ),
        (lines("seq_000000,-1,head,0,0,1"), ":2: frame -1 is not in the sequence"),
        (lines("seq_000000,1.5,head,0,0,1"), ":2: frame must be a whole number, got '1.5'"),
        (lines("seq_000000,,head,0,0,1"), ":2: frame must be a whole number"),
        (lines(GOOD, "", GOOD), ":4: head of frame 0 is there a second time"),
        (lines("seq_000000,0,nose,0,0,1"), ":2: target must be of head, right_hand, left_hand"),
        (lines("seq_000000,0,head,a,0,1"), ":2: x_m must be a number, got 'a'"),
        (lines("seq_000000,0,head,0,nan,1"), ":2: y_m is nan; where there is no estimate"),
        (lines("seq_000000,0,head,0,0,-inf"), ":2: z_m is -inf"),
        (lines("seq_000000,0,head,0,0,1e300"), ":2: z_m is 1e+300: metres are expected"),
        (lines("seq_000000,0,head,0,,1"), ":2: y_m is empty; give all of x_m, y_m, z_m or none"),
        (lines("seq_000000,0,head,0,0"), ":2: has 5 cells, the first line has 6"),
        (lines(GOOD + ",seen", header=HEADER + ",status"), ":2: status must be of"),
        (
            lines("seq_000000,0,head,,,,tracked", header=HEADER + ",status"),
            ":2: head is tracked but has no",
        ),
        (
            lines(GOOD + ",1,1,-1", header=HEADER + ",sd_x_m,sd_y_m,sd_z_m"),
            ":2: sd_x_m, sd_y_m, sd_z_m must be 0 or more",
        ),
        (
            lines(GOOD + ",0.5", header=HEADER + ",exchange_probability"),
            ":2: exchange_probability goes into the hands' rows, not the head's",
        ),
        (
            lines("seq_000000,0,left_hand,0,0,1,1.5", header=HEADER + ",exchange_probability"),
            ":2: exchange_probability must be from 0 to 1, got 1.5",
        ),
        (
            lines(
                "seq_000000,0,left_hand,0,0,1,0.5",
                "seq_000000,0,right_hand,0,0,1,0.4",
                header=HEADER + ",exchange_probability",
            ),
            ":3: exchange_probability is 0.4, of the other hand it is another",
        ),
        (lines("seq_000000,0,head,100,0,1200", "seq_000000,1,head,90,0,1300"), "metres are expe"),
        (lines('seq_000000,0,"head' + "x" * 200_000), ":2: is not CSV"),
    ],
)
def test_a_fault_in_the_tracks_is_one_line_with_its_place(made, tmp_path, text, said):
    path = tmp_path / "tracks.csv"
    path.write_text(text)
    with pytest.raises(BenchError) as caught:
        scored(made, path, tmp_path)
    assert str(caught.value).startswith(f"{path}:")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2
    assert not (tmp_path / "scored").exists()


def test_text_that_is_not_utf8_is_told_with_its_line(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(lines(GOOD).encode() + b"seq_000000,1,h\xe9ad,0,0,1\n")
    with pytest.raises(BenchError, match=r"t.csv:\d+: is not UTF-8"):
        read_tracks(path, COUNTS)


def test_spreadsheet_files_are_read(tmp_path):
    """A byte order mark, other line ends, blanks, an empty last line, floats for frames."""
    path = tmp_path / "t.csv"
    text = lines("seq_000000, 1.0 , head , 0.5,0,1", "").replace("\n", "\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    tracks = read_tracks(path, COUNTS)["seq_000000"]
    assert tracks.positions_m[1, 0].tolist() == [0.5, 0, 1]
    assert tracks.status[1] == ("tracked", "lost", "lost")


def test_one_sequence_needs_no_column_sequence(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(
        "frame,target,x_m,y_m,z_m,status\n2,left_hand,1,2,3,coasting\n3,head,,,,waiting"
    )
    (tracks,) = read_tracks(path, {"seq_000000": 4}).values()
    assert tracks.status[2] == ("lost", "lost", "coasting")
    assert tracks.status[3][0] == "waiting"
    assert np.isnan(tracks.positions_m[3]).all()
    with pytest.raises(BenchError, match=r"lacks the column sequence; .* give FOLDER"):
        read_tracks(path, COUNTS)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.assign(x_m=np.where(t.index == 5, np.inf, t["x_m"])), ": row 6: x_m is inf"),
        (lambda t: t.assign(frame=t["frame"] + 1), "is not in the sequence"),
        (lambda t: t.drop(columns="z_m"), "lacks the column z_m"),
        (lambda t: t.assign(x_m=[[1.0]] * len(t)), "column 'x_m' must be numbers or text"),
        (lambda t: t.assign(x_m=1e3 * t["x_m"] + 1e5), "metres are expected, not mm"),
    ],
)
def test_a_fault_in_parquet_is_one_line(made, truth, tmp_path, change, said):
    path = written(change(truth), tmp_path / "t.parquet")
    with pytest.raises(BenchError) as caught:
        scored(made, path, tmp_path)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_numbers_in_parquet_are_no_estimates(truth, tmp_path):
    table = truth.copy()
    table.loc[4, ["x_m", "y_m", "z_m"]] = None
    tracks = read_tracks(written(table, tmp_path / "t.parquet"), COUNTS)
    assert tracks["seq_000000"].status[1] == ("tracked", "lost", "tracked")


def test_a_damaged_parquet_file_is_one_line(truth, tmp_path):
    path = written(truth, tmp_path / "t.parquet")
    data = path.read_bytes()
    for size in (0, 10, len(data) // 2):
        path.write_bytes(data[:size])
        with pytest.raises(BenchError, match=r"cannot be read as Parquet: [^\n]*$"):
            read_tracks(path, COUNTS)


ROW = "frame,target,x_m,y_m,z_m\n0,head,0,0,1\n"


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({}, "has no tracks: it must have files such as seq_000000.csv"),
        ({"notes.txt": "hello"}, "has no tracks"),
        ({"seq_000007.csv": ROW}, "seq_000007.csv: is named after no sequence"),
        ({"tracks.csv": ROW}, "tracks.csv: is named after no sequence"),
        ({"seq_000000.csv": ROW, "seq_000000/tracks.csv": ROW}, "seq_000000 is in"),
        ({"seq_000001/other.csv": ROW}, "seq_000001: has no tracks.csv"),
        ({"seq_000001.csv": ROW + "4,head,0,0,1\n"}, "seq_000001.csv:3: frame 4 is not"),
    ],
)
def test_a_fault_in_a_folder_of_tracks_is_one_line(tmp_path, files, said):
    folder = tmp_path / "tracks"
    folder.mkdir()
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    with pytest.raises(BenchError) as caught:
        read_tracks(folder, COUNTS)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"frame": "right"}, "--frame must be world or left, got 'right'"),
        ({"tracks": Path("nothing.csv")}, "nothing.csv: no such file"),
        ({"tracks": Path(__file__)}, "must end in .csv or .parquet"),
        ({"out": ROOT}, "exists and is not empty"),
    ],
)
def test_what_was_asked_for_wrongly_is_one_line(made, tmp_path, changes, said):
    asked = {"dataset": made, "tracks": tmp_path, "out": tmp_path / "out", **changes}
    with pytest.raises(BenchError, match=r"[^\n]*$") as caught:
        score_tracks(ScoreRequest(**asked))
    assert said in str(caught.value)
