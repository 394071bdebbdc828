"""Reading a run: the stored numbers, and every damage named in a line."""

import json
import shutil

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from reports.run.load import load
from reports.run.schema import EPISODES, EVENTS, FRAMES, TABLES

FILES = tuple(f"{name}.parquet" for name in TABLES)


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


@pytest.mark.parametrize("name", [*FILES, "run.json"])
def test_a_missing_file_is_named(run, name):
    (run / name).unlink()
    with pytest.raises(BenchError, match=name.replace(".", r"\.")):
        load(run)


@pytest.mark.parametrize("name", FILES)
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
        (lambda m: m["scenarios"][0]["digests"].pop(), "digests of .* do not match its seeds"),
        (lambda m: m["scenarios"][0].pop("truths"), "truths of .* do not match its seeds"),
        (lambda m: m["scenarios"][0]["seeds"].__setitem__(0, 77), "not those of episodes.parquet"),
        (lambda m: m.update(scenarios=[]), "not those of episodes.parquet"),
        (lambda m: m.update(suites=[{"name": "core"}]), "suites have no name, version and digest"),
        (lambda m: m.update(request={"targets": []}), "'request' is not complete"),
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
