"""What the Rerun viewer gets: the run's own numbers, under the right names, whole or not at all."""

import resource
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest

from pjpdaf.camera import project
from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.frames import StereoFrame
from pjpdaf.targets import TARGETS
from reports.page.episode_tables import episode_tables
from reports.pictures.stills import still
from reports.rerun.run import recording_id, write_rerun
from reports.rerun.run_entities import CORNER_PX, TRAIL_S
from reports.run.load import load
from reports.run.save import RunInfo, save, save_slim
from reports.score.records import VIEWS, Still

F = 20
BASE = "/calm\\ table/3"  # as Rerun writes "calm table", seed 3


@pytest.fixture(scope="module")
def episode(episode_of, tools):
    """No estimates in the first two frames, hands swapped from frame 9 on; every 5th filmed."""
    cameras = tools.cameras((-0.2, 0.05, 0.0, 0.0))
    centres = tools.paths(F, 3.0)
    estimates = tools.noisy(centres, 3)
    estimates[:2] = np.nan
    estimates[9:, 1:] = estimates[9:, :0:-1].copy()
    played = episode_of(
        estimates,
        centres_m=centres,
        cameras=cameras,
        scenario="calm table",
        seed=3,
        labels=lambda f: ("reach",) if f < 7 else ("hold", "near"),
    )
    left, right = np.full((480, 640, 3), 60, np.uint8), np.full((480, 640, 3), 180, np.uint8)
    webp = still(StereoFrame(0, 0.0, (left, right)), cameras)
    spread = np.diag([4e-4, 9e-4, 1e-4])
    frames = tuple(
        replace(o, estimates=replace(o.estimates, covariances_m2=np.stack([spread] * 3)))
        for o in played.frames
    )
    return replace(played, frames=frames, film=tuple(Still(f, webp) for f in range(0, F, 5)))


@pytest.fixture(scope="module")
def run(episode, tmp_path_factory):
    return load(save(tmp_path_factory.mktemp("rerun") / "run", [episode], RunInfo("run")))


@pytest.fixture(scope="module")
def read():
    """Of a file its recording's id, and entity -> column -> values, rows in order of time."""
    pytest.importorskip("rerun", reason="needs the extra viz")
    chunks = pytest.importorskip("rerun.chunk", reason="this Rerun cannot read its own files")

    def reader(file):
        rrd = chunks.RrdReader(file)
        assert len(rrd.recordings()) == len(rrd.blueprints()) == 1
        found = {}
        for chunk in rrd.stream():
            entity = found.setdefault(chunk.entity_path, {})
            for name, values in chunk.to_record_batch().to_pydict().items():
                if name != "rerun.controls.RowId":
                    entity.setdefault(name, []).extend(values)
        return rrd.recordings()[0].recording_id, found

    return reader


@pytest.fixture(scope="module")
def recorded(run, read):
    return read(write_rerun(run, run.folder.parent / "out.rrd"))[1]


def points(entity, name):
    """(n, 3), NaN in empty rows."""
    return np.array([row[0] if row else [np.nan] * 3 for row in entity[name]])


def test_every_entity_has_a_row_a_frame(recorded):
    moving = {
        *(f"cameras/{view}/{what}" for view in VIEWS for what in ("picture", "detections")),
        *(
            f"{what}/{target}"
            for what in ("truth", "estimate", "covariance", "error_mm", "err_acc_px")
            for target in TARGETS
        ),
        *(f"trail/{kind}/{target}" for kind in ("truth", "estimate") for target in TARGETS),
    }
    still_ones = {"", *(f"/cameras/{view}" for view in VIEWS), "/events", "/labels"}
    ours = {path.removeprefix(BASE) for path in recorded if path.startswith(BASE)}
    assert ours == {f"/{path}" for path in moving} | still_ones
    for path in moving:
        entity = recorded[f"{BASE}/{path}"]
        assert entity["frame"] == list(range(F)), path
        seconds = [t.total_seconds() for t in entity["time"]]
        np.testing.assert_allclose(seconds, np.arange(F) / 3.0, atol=1e-6)
    # No wall clock, so that equal runs are equal.
    assert {"log_time", "log_tick"}.isdisjoint(name for e in recorded.values() for name in e)


def test_points_and_errors_are_the_runs_own(recorded, run, episode):
    take = next(episode_tables(run))
    for t, target in enumerate(TARGETS):
        said = points(recorded[f"{BASE}/estimate/{target}"], "Points3D:positions")
        truth = points(recorded[f"{BASE}/truth/{target}"], "Points3D:positions")
        wanted = np.stack([o.estimates.positions_m[t] for o in episode.frames])
        np.testing.assert_allclose(said, wanted, atol=1e-6)
        assert np.isnan(said[:2]).all()
        np.testing.assert_allclose(
            truth, np.stack([o.truth.centres_m[t] for o in episode.frames]), atol=1e-6
        )
        errors = [row[0] if row else np.nan for row in error_rows(recorded, target)]
        np.testing.assert_array_equal(errors, take.column("error_mm")[:, t])


def error_rows(recorded, target):
    return recorded[f"{BASE}/error_mm/{target}"]["Scalars:scalars"]


def test_truth_seen_through_the_pinholes_lies_in_the_detections(recorded, episode):
    for v, view in enumerate(VIEWS):
        camera = recorded[f"{BASE}/cameras/{view}"]
        K = np.array(camera["Pinhole:image_from_camera"][0][0]).reshape(3, 3).T
        R_wc = np.array(camera["Transform3D:mat3x3"][0][0]).reshape(3, 3).T
        centre = np.array(camera["Transform3D:translation"][0][0])
        seen = recorded[f"{BASE}/cameras/{view}/detections"]["LineStrips2D:strips"]
        assert [len(row) for row in seen] == [3] * F
        for f in (0, 11):
            for t in range(3):
                q = K @ R_wc.T @ (episode.frames[f].truth.centres_m[t] - centre)
                ideal = project(episode.cameras[v], episode.frames[f].truth.centres_m[t])
                np.testing.assert_allclose(q[:2] / q[2], ideal + CORNER_PX, atol=2e-3)
                outline = np.array(seen[f][t])
                np.testing.assert_allclose(outline[0], outline[-1])
                np.testing.assert_allclose(outline[:-1].mean(0), ideal + CORNER_PX, atol=2e-3)


def test_pictures_are_of_their_view_and_do_not_stay(recorded):
    for view, grey in (("left", 60), ("right", 180)):
        rows = recorded[f"{BASE}/cameras/{view}/picture"]["EncodedImage:blob"]
        assert [f for f, row in enumerate(rows) if row] == [0, 5, 10, 15]
        picture = cv2.imdecode(np.array(rows[5][0], np.uint8), cv2.IMREAD_COLOR)
        assert picture.shape == (480, 640, 3)
        assert abs(int(picture[240, 320, 0]) - grey) < 5


def test_ellipsoids_are_the_covariances(recorded):
    entity = recorded[f"{BASE}/covariance/head"]
    rows = entity["Ellipsoids3D:half_sizes"]
    assert [len(row) for row in rows] == [0, 0] + [1] * (F - 2)
    half = np.array(rows[4][0])
    x, y, z, w = entity["Ellipsoids3D:quaternions"][4][0]
    R = np.array(  # from the quaternion's definition
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    spread = R @ np.diag((half / 2) ** 2) @ R.T
    np.testing.assert_allclose(spread, np.diag([4e-4, 9e-4, 1e-4]), atol=1e-9)


def test_trails_end_at_the_point_and_are_cut_at_gaps(recorded):
    trails = recorded[f"{BASE}/trail/estimate/head"]["LineStrips3D:strips"]
    said = points(recorded[f"{BASE}/estimate/head"], "Points3D:positions")
    assert [len(row) for row in trails] == [0, 0, 0] + [1] * (F - 3)
    np.testing.assert_allclose(trails[15][0], said[15 - round(TRAIL_S * 3) : 16])


def test_events_and_labels_stand_where_they_happen(recorded, run):
    events = recorded[f"{BASE}/events"]
    texts = [row[0] for row in events["TextLog:text"]]
    assert len(texts) == len(run.events)
    swap = texts.index(next(text for text in texts if text.startswith("hands swapped for")))
    assert events["frame"][swap] == 9
    labels = recorded[f"{BASE}/labels"]
    assert labels["frame"] == [0, 7]
    assert [row[0] for row in labels["TextLog:text"]] == ["reach", "hold, near"]


def test_a_target_without_any_estimate_is_left_out(episode_of, tools, tmp_path, read):
    estimates = tools.paths(6, 3.0)
    estimates[:, 2] = np.nan
    played = episode_of(estimates, centres_m=tools.paths(6, 3.0), frames=6)
    saved = load(save(tmp_path / "run", [played], RunInfo("run")))
    _, found = read(write_rerun(saved, tmp_path / "a.rrd"))
    assert "Points3D:positions" in found["/calm_table/0/estimate/right_hand"]
    assert "Points3D:positions" not in found["/calm_table/0/estimate/left_hand"]
    assert "/calm_table/0/cameras/left/picture" not in found


def test_equal_runs_give_equal_content(recorded, run, tmp_path, read):
    assert read(write_rerun(run, tmp_path / "again.rrd")) == (recording_id(run), recorded)
    assert recording_id(replace(run, meta={**run.meta, "files": {}})) != recording_id(run)


def test_what_cannot_be_written_is_said_and_leaves_nothing(run, tmp_path, read):
    taken = tmp_path / "taken.rrd"
    taken.write_text("mine")
    with pytest.raises(BenchError, match="exists; give another name"):
        write_rerun(run, taken)
    assert taken.read_text() == "mine"
    with pytest.raises(BenchError, match="Make its folder first"):
        write_rerun(run, tmp_path / "no" / "out.rrd")
    assert names(tmp_path) == ["taken.rrd"]


def test_rerun_switched_off_is_said(run, tmp_path, read, monkeypatch):
    monkeypatch.setenv("RERUN", "0")
    with pytest.raises(InfrastructureError, match="unset it"):
        write_rerun(run, tmp_path / "out.rrd")
    assert names(tmp_path) == []


def test_a_disk_that_refuses_is_said_and_leaves_nothing(run, tmp_path, read):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(BenchError, match=r"/out\.rrd: cannot write the recording: File too"):
            write_rerun(run, tmp_path / "out.rrd")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert names(tmp_path) == []


def test_what_cannot_be_shown_is_said_before_rerun_is_asked_for(run, tmp_path):
    with pytest.raises(BenchError, match=r"must end in \.rrd"):
        write_rerun(run, tmp_path / "out.mp4")
    with pytest.raises(BenchError, match="slim run"):
        write_rerun(load(save_slim(run, tmp_path / "slim")), tmp_path / "out.rrd")
    with pytest.raises(BenchError, match="no episode has a result"):
        write_rerun(replace(run, frames=run.frames.iloc[:0]), tmp_path / "out.rrd")
    assert names(tmp_path) == ["slim"]


def test_without_rerun_it_says_how_to_get_it(run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)  # as where it is not installed
    with pytest.raises(InfrastructureError, match=r"pip install 'pjpdaf-bench\[viz\]'") as fault:
        write_rerun(run, tmp_path / "out.rrd")
    assert "\n" not in str(fault.value)
    assert names(tmp_path) == []


def names(folder):
    return sorted(path.name for path in folder.iterdir())
