"""Saved runs: the same bytes in any order, whole or absent, damage named."""

import json
import os
import pickle
import random
import shutil
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pjpdaf.errors import BenchError
from reports.gate.pairing import SAME_MOTION_UM
from reports.run.results import RunInfo, check_free, load, read_film, save, save_slim
from reports.run.rows import CAMERAS, DETECTIONS, EPISODES, EVENTS, FRAMES, motion_mark, rows_of
from reports.score.records import EpisodeFailure, Picture, Still

TABLES = tuple(
    f"{name}.parquet"
    for name in ("frames", "episodes", "events", "tracking", "detections", "cameras")
)
INFO = RunInfo("night", preset="default", overrides={"gate": 15.0}, argv=("run", "calm_table"))


@pytest.fixture(scope="module")
def played(episode_of, tools):
    episodes = []
    for scenario in ("calm_table", "cross"):
        for seed in range(3):
            centres = tools.paths(12, 3.0)
            estimates = tools.noisy(centres, seed)
            if scenario == "cross" and seed == 1:
                estimates[5:] = estimates[5:][:, [0, 2, 1]]
            picture = Picture(3, b"\xff\xd8jpeg")
            episodes.append(
                replace(
                    episode_of(
                        estimates,
                        centres_m=centres,
                        scenario=scenario,
                        seed=seed,
                        pictures=(picture,),
                    ),
                    film=tuple(Still(f, f"RIFF {seed} {f}".encode()) for f in (0, 3, 11)),
                )
            )
    return [*episodes, EpisodeFailure("cross", 3, "timed out", group="hand and hand")]


@pytest.fixture
def run(played, tmp_path):
    return save(tmp_path / "night", played, INFO)


def test_round_trip(run, played):
    read = load(run)
    assert read.name == "night"
    assert list(read.frames.columns) == FRAMES.names
    assert list(read.episodes.columns) == EPISODES.names
    assert list(read.events.columns) == EVENTS.names
    assert len(read.frames) == 6 * 12 * 3
    first = read.frames.iloc[0]
    assert (first.scenario, first.seed, first.frame, first.target) == ("calm_table", 0, 0, "head")
    outcome = played[0].frames[0]
    assert first.estimate_y_m == outcome.estimates.positions_m[0, 1]
    error = np.linalg.norm(outcome.estimates.positions_m[0] - outcome.truth.centres_m[0])
    assert first.error_mm == pytest.approx(1e3 * error)
    assert read.episodes.query("failure != ''").seed.tolist() == [3, 3, 3]
    swaps = read.events.query("kind == 'swap'")
    assert swaps[["scenario", "seed", "first_frame", "ended"]].to_numpy().tolist() == [
        ["cross", 1, 5, False]
    ]


def test_what_was_detected_is_there_in_its_order(run, played):
    read = load(run)
    assert list(read.detections.columns) == DETECTIONS.names
    assert list(read.cameras.columns) == CAMERAS.names
    assert len(read.detections) == 6 * 12 * 2 * 3
    mine = read.detections.query("scenario == 'cross' and seed == 2 and frame == 7")
    assert mine.view.tolist() == ["left"] * 3 + ["right"] * 3
    seen = played[5].frames[7].detections
    shape = mine[["x_px", "y_px", "a_px", "b_px", "angle_rad"]].to_numpy()
    np.testing.assert_array_equal(shape, np.vstack([view.ellipses for view in seen]))
    assert mine.area_px.tolist() == [1500.0] * 6
    camera = played[5].cameras[1]
    row = read.cameras.query("scenario == 'cross' and seed == 2 and view == 'right'").iloc[0]
    np.testing.assert_array_equal(np.reshape(row.K, (3, 3)), camera.K)
    np.testing.assert_array_equal(np.reshape(row.R_cw, (3, 3)), camera.R_cw)
    np.testing.assert_array_equal(row.t_cw, camera.t_cw)


def test_frames_without_detections_have_no_rows(episode_of, tmp_path):
    episode = episode_of(frames=4)
    blind = replace(
        episode, frames=tuple(replace(outcome, detections=()) for outcome in episode.frames)
    )
    assert len(load(save(tmp_path / "run", [blind], INFO)).detections) == 0


def test_films_are_kept_whole_and_checked(run):
    read = load(run)
    # Both first seeds, and the one that swapped.
    kept = [(film["scenario"], film["seed"], film["frames"]) for film in read.meta["films"]]
    assert kept == [("calm_table", 0, 3), ("cross", 0, 3), ("cross", 1, 3)]
    assert not any(film["whole"] for film in read.meta["films"])
    film = read.meta["films"][2]["file"]
    assert read_film(read, film) == {f: f"RIFF 1 {f}".encode() for f in (0, 3, 11)}
    (run / film).write_bytes(b"PK")
    with pytest.raises(BenchError, match=r"0004_cross_1\.zip: is damaged"):
        read_film(read, film)
    with pytest.raises(BenchError, match=r"0004_cross_1\.zip: is damaged"):
        load(run)


def test_counts_and_sums_agree_with_the_frames(run):
    read = load(run)
    episodes = read.episodes.set_index(["scenario", "seed", "target"])
    for key, rows in read.frames.groupby(["scenario", "seed", "target"]):
        episode = episodes.loc[key]
        assert episode.frames == len(rows)
        assert episode.within_50 == (rows.error_mm <= 50).sum()
        assert episode.sum_error_mm == pytest.approx(rows.error_mm.sum())
        assert episode.sum_abs_depth_mm == pytest.approx(rows.depth_mm.abs().sum())
        assert episode.n_nees == len(rows)
        assert episode.merged_frames == 0


def test_merged_frames_alone(episode_of):
    pair = np.zeros((3, 3), bool)
    pair[1, 2] = pair[2, 1] = True
    none = np.zeros((3, 3), bool)
    rows = rows_of(episode_of(merged=lambda f: (pair if f < 4 else none, none))).episodes
    assert [row["merged_frames"] for row in rows] == [0, 4, 4]
    assert rows[1]["merged_within_100"] == 4


@settings(
    max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(shuffle=st.randoms(use_true_random=False))
def test_the_order_of_episodes_changes_no_byte(played, tmp_path_factory, shuffle: random.Random):
    base = tmp_path_factory.mktemp("order")
    mixed = list(played)
    shuffle.shuffle(mixed)
    straight, shuffled = save(base / "a", played, INFO), save(base / "b", mixed, INFO)
    for name in TABLES:
        assert (straight / name).read_bytes() == (shuffled / name).read_bytes(), name
    for film in sorted(straight.glob("films/*")):
        assert film.read_bytes() == (shuffled / "films" / film.name).read_bytes()
    assert (straight / "run.json").read_bytes() == (shuffled / "run.json").read_bytes()


def test_wall_time_is_in_no_table(played, episode_of, tmp_path):
    for name, seconds in (("slow", 9.0), ("quick", 0.1)):
        save(tmp_path / name, [episode_of(stage_s={"detect": seconds})], INFO)
    for name in TABLES:
        assert (tmp_path / "slow" / name).read_bytes() == (tmp_path / "quick" / name).read_bytes()
    timing = load(tmp_path / "slow").meta["timing"]
    assert timing[0]["stage_s"]["detect"] == pytest.approx(9.0 * 30)


def test_rows_made_in_a_worker_are_as_good_as_the_episode(played, tmp_path):
    save(tmp_path / "a", played, INFO)
    sent = [pickle.loads(pickle.dumps(rows_of(one))) for one in reversed(played)]
    save(tmp_path / "b", sent, INFO)
    for name in TABLES:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_provenance_and_checksums_are_recorded(run):
    meta = json.loads((run / "run.json").read_text(encoding="utf-8"))
    assert meta["provenance"]["argv"] == ["run", "calm_table"]
    assert meta["provenance"]["versions"]["numpy"] == np.__version__
    assert meta["scenarios"][1]["seeds"] == [0, 1, 2, 3]
    assert meta["scenarios"][1]["failures"] == [{"seed": 3, "reason": "timed out"}]
    assert set(TABLES) < set(meta["files"])
    assert len(meta["pictures"]) == 6
    assert meta["complete"] is True


def test_nothing_else_lies_beside_the_run(run):
    assert [p.name for p in run.parent.iterdir()] == ["night"]


def test_a_run_without_episodes_can_be_saved_and_read(tmp_path):
    read = load(save(tmp_path / "empty", [], RunInfo("empty", complete=False)))
    assert len(read.frames) == 0
    assert read.meta["complete"] is False


def test_a_fault_while_writing_leaves_nothing(played, tmp_path, monkeypatch):
    def broken(*_args, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("reports.run.results.write_table", broken)
    with pytest.raises(BenchError, match=r"night: cannot write the run: No space left on device\."):
        save(tmp_path / "night", played, INFO)
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_while_replacing_keeps_the_old_run(run, played, monkeypatch):
    def interrupted(*_args, **_options):
        raise KeyboardInterrupt

    before = (run / "run.json").read_bytes()
    monkeypatch.setattr("reports.run.results.write_table", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save(run, played[:1], INFO, force=True)
    assert (run / "run.json").read_bytes() == before
    assert [p.name for p in run.parent.iterdir()] == ["night"]


def test_an_existing_folder(run, played, tmp_path):
    with pytest.raises(BenchError, match="exists and is not empty; give another folder"):
        save(run, played, INFO)
    save(run, played[:1], INFO, force=True)
    assert len(load(run).meta["timing"]) == 1
    (tmp_path / "blank").mkdir()
    save(tmp_path / "blank", played[:1], INFO)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    with pytest.raises(BenchError, match="is not a saved run, so it is not replaced"):
        save(tmp_path / "mine", played, INFO, force=True)
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="is a file; give a new folder"):
        check_free(tmp_path / "file")
    with pytest.raises(BenchError, match="cannot write the run"):
        save(tmp_path / "file" / "below", played, INFO)


def test_an_unwritable_folder_is_one_line(played, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_args: False)  # root may write anywhere
    for folder in (tmp_path / "night", tmp_path / "some" / "where" / "night", tmp_path):
        with pytest.raises(BenchError, match=r"cannot write the run: .* is not writable\.$"):
            save(folder, played, INFO)


def test_the_same_episode_twice_is_refused(played, tmp_path):
    with pytest.raises(BenchError, match="'calm_table' seed 0 was given twice"):
        save(tmp_path / "night", [played[0], played[0]], INFO)


@pytest.mark.parametrize("name", [*TABLES, "run.json"])
def test_a_missing_file_is_named(run, name):
    (run / name).unlink()
    with pytest.raises(BenchError, match=name.replace(".", r"\.")):
        load(run)


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("how", ["flip", "cut", "empty"])
def test_a_damaged_file_is_named(run, name, how):
    content = bytearray((run / name).read_bytes())
    content[len(content) // 2] ^= 1
    new = {"flip": bytes(content), "cut": bytes(content[:-9]), "empty": b""}[how]
    (run / name).write_bytes(new)
    with pytest.raises(BenchError, match=f"{name}: is damaged") as caught:
        load(run)
    assert "\n" not in str(caught.value)


def test_a_damaged_picture_is_named(run):
    picture = next(run.rglob("*.jpg"))
    picture.write_bytes(b"")
    with pytest.raises(BenchError, match=picture.name):
        load(run)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: m.update(schema_version=99), "schema version 99; this version reads 2"),
        (lambda m: m.update(kind="?"), "is not the run.json of a saved run"),
        (lambda m: m.pop("files"), "'files' is missing or not a dict"),
        (lambda m: m["files"].pop("events.parquet"), "events.parquet is not listed"),
        (lambda m: m["files"].update({"../x": {}}), "which is outside the run"),
        (lambda m: m["pictures"][0].update(file="/etc/passwd"), "a picture is not listed"),
        (lambda m: m["films"][0].update(file="../film.zip"), "a film is not listed"),
        (lambda m: m["scenarios"][0].pop("name"), "a scenario has no name"),
        (lambda m: m.update(scenarios=["cross"]), "a scenario has no name"),
        (lambda m: m["scenarios"][0].update(seeds=["0"]), "the seeds of .* are no list"),
        (lambda m: m["scenarios"][0]["digests"].pop(), "digests of .* are not one a seed"),
        (lambda m: m["scenarios"][0].pop("truths"), "truths of .* are not one a seed"),
        (lambda m: m["scenarios"][0]["seeds"].__setitem__(0, 77), "not those of episodes.parquet"),
        (lambda m: m.update(scenarios=[]), "not those of episodes.parquet"),
        (lambda m: m.update(suites=[{"name": "core"}]), "suites have no name, version and digest"),
        (lambda m: m.update(request={"targets": []}), "'request' does not say"),
        (lambda m: m.update(provenance={}), "'provenance' has no versions"),
    ],
)
def test_a_wrong_run_json_is_one_line(run, change, message):
    path = run / "run.json"
    meta = json.loads(path.read_text(encoding="utf-8"))
    change(meta)
    path.write_text(json.dumps(meta), encoding="utf-8")
    with pytest.raises(BenchError, match=message):
        load(run)


def test_a_whole_run_is_not_replaced_by_its_own_slim_copy(run):
    with pytest.raises(BenchError, match="is the whole run itself"):
        save_slim(load(run), run, force=True)
    assert not load(run).slim


def test_the_mark_of_a_motion_outlives_other_rounding_but_no_other_motion(tools):
    rng = np.random.default_rng(100)
    for seed in range(100, 120):
        centres_m = tools.paths(24, 3.0, 0.1 + 0.01 * (seed - 100))
        mark = np.array(motion_mark(centres_m).split(), dtype=int)

        def off(changed_m, mark=mark):
            return np.abs(np.array(motion_mark(changed_m).split(), dtype=int) - mark).max()

        assert off(centres_m + rng.normal(0, 1e-9, centres_m.shape)) <= SAME_MOTION_UM
        one = centres_m.copy()
        one[rng.integers(24), rng.integers(3), rng.integers(3)] += 0.005
        assert off(one) > 0
        assert off(centres_m + 1e-4) > SAME_MOTION_UM
        assert off(centres_m[:-1]) > SAME_MOTION_UM
        assert off(centres_m[:, [0, 2, 1]]) > SAME_MOTION_UM


def test_half_a_run_json_and_no_run_at_all(run, tmp_path):
    path = run / "run.json"
    path.write_text(path.read_text(encoding="utf-8")[:100], encoding="utf-8")
    with pytest.raises(BenchError, match=r"run\.json: is damaged"):
        load(run)
    with pytest.raises(BenchError, match="no such run"):
        load(tmp_path / "nowhere")
    shutil.rmtree(run / "pictures")
    path.unlink()
    with pytest.raises(BenchError, match="is not a saved run"):
        load(run)


def test_hostile_scenario_names_stay_inside_the_folder(episode_of, tmp_path):
    picture = Picture(0, b"\xff\xd8")
    episode = episode_of(frames=3, scenario="../../<b>évil", pictures=(picture,))
    folder = save(tmp_path / "night", [episode], INFO)
    assert {p.name for p in tmp_path.iterdir()} == {"night"}
    assert load(folder).frames.scenario.iloc[0] == "../../<b>évil"
