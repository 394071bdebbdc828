"""Reading a run: the stored numbers, and every damage named in a line."""

import json
import shutil
import zipfile

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pjpdaf.errors import BenchError
from reports.run.load import load, read_film
from reports.run.schema import EPISODES, EVENTS, FRAMES, TABLES
from sim.dataset.files.checksums import sha256_of

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
        (lambda m: m.pop("files"), "files: is missing"),
        (lambda m: m["files"].pop("events.parquet"), "events.parquet is not listed"),
        (lambda m: m["files"].update({"../x": {"sha256": "0" * 64}}), "which is outside the run"),
        (lambda m: m["pictures"][0].update(file="/etc/passwd"), "a picture is not listed"),
        (lambda m: m["films"][0].update(file="../film.zip"), "a film is not listed"),
        (lambda m: m["scenarios"][0].pop("name"), r"scenarios\.0\.name: is missing"),
        (lambda m: m.update(scenarios=["cross"]), r"scenarios\.0: must be a mapping"),
        (
            lambda m: m["scenarios"][0].update(seeds=["0"]),
            r"scenarios\.0\.seeds\.0: .* valid int",
        ),
        (lambda m: m["scenarios"][0]["digests"].pop(), "digests of .* do not match its seeds"),
        (lambda m: m["scenarios"][0].pop("truths"), r"scenarios\.0\.truths: is missing"),
        (lambda m: m["scenarios"][0]["seeds"].__setitem__(0, 77), "no episode calm_table seed 0"),
        (lambda m: m.update(scenarios=[]), "no episode calm_table seed 0"),
        (lambda m: m.update(suites=[{"name": "core"}]), r"suites\.0\.version: is missing"),
        (lambda m: m.update(request={"targets": []}), r"request\.seeds: is missing"),
        (lambda m: m["pictures"][0].update(file=[]), r"pictures\.0\.file: .* valid string"),
        (lambda m: m.pop("overrides"), "overrides: is missing"),
        (lambda m: m.update(timing=[3]), r"timing\.0: must be a mapping"),
        (lambda m: m.update(tracker="\ud800"), "surrogates not allowed"),
        (lambda m: m["parameters"].update(x=["\ud800"]), "surrogates not allowed"),
        (lambda m: m["scenarios"][0]["seeds"].__setitem__(0, 1), "a seed of calm_table is .*twice"),
        (lambda m: m["scenarios"].append(m["scenarios"][0]), "a scenario is there twice"),
        (lambda m: m["scenarios"][0].update(name="x" * 10**5), "at most 10000 characters"),
        (lambda m: m.update(provenance={}), r"provenance\.versions: is missing"),
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
    with pytest.raises(BenchError, match="no such run; give the folder that `run --out` made"):
        load(tmp_path / "nowhere")
    with pytest.raises(BenchError, match=rf"no such run; did you mean {run}\?; give the folder"):
        load(run.with_name(f"{run.name}s"))
    shutil.rmtree(run / "pictures")
    path.unlink()
    with pytest.raises(BenchError, match="is not a saved run"):
        load(run)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000], ids=["lists", "mappings"])
def test_a_run_json_nested_without_end_is_one_line(run, text):
    (run / "run.json").write_text(text)
    with pytest.raises(BenchError, match=r"run\.json: is damaged: nested too deeply"):
        load(run)


def rewritten(run, name, change):
    """Change a table by a function of its rows (a list of dicts), with its checksum made anew."""
    path = run / f"{name}.parquet"
    rows = pq.read_table(path).to_pylist()
    schema = pq.read_schema(path)
    pq.write_table(pa.Table.from_pylist(change(rows), schema=schema), path)
    with_checksum(run, path)


def with_checksum(run, path):
    meta = json.loads((run / "run.json").read_text(encoding="utf-8"))
    meta["files"][path.relative_to(run).as_posix()]["sha256"] = sha256_of(path)
    (run / "run.json").write_text(json.dumps(meta), encoding="utf-8")


def with_cells(row, **cells):
    """A change of one row."""
    return lambda rows: [*rows[:row], {**rows[row], **cells}, *rows[row + 1 :]]


NAN = float("nan")


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        (
            "episodes",
            with_cells(1, median_error_mm=-50.0),
            r"row 2 .*median_error_mm is -50,",
        ),
        ("episodes", with_cells(0, frames=0), r"row 1 \(calm_table seed 0 head\): frames is 0 in"),
        ("episodes", with_cells(0, ever_swapped=None), "row 1 .*: ever_swapped is empty"),
        ("episodes", with_cells(2, within_100=99), r"row 3 .*: within_100 is 99, more than frames"),
        (
            "episodes",
            with_cells(2, within_50=12, within_100=3),
            "within_50 is 12, more",
        ),
        ("episodes", with_cells(0, sum_error_mm=NAN), "sum_error_mm is not a finite number"),
        ("episodes", with_cells(0, frames=13), "frames is not that of the episode"),
        ("episodes", with_cells(0, target="foot"), "target must be of head, .* got 'foot'"),
        ("episodes", with_cells(0, swaps=1), "ever_swapped is false, but swaps is above 0"),
        ("episodes", lambda rows: [*rows, rows[0]], "not those of episodes.parquet|there twice"),
        ("tracking", with_cells(0, sum_gospa_mm=-1.0), "row 1 .*sum_gospa_mm is -1, below 0"),
        ("tracking", with_cells(0, sum_gospa_mm=1e9), "sum_gospa_mm is above its most"),
        ("tracking", with_cells(3, frames=5), "numbers of frames, are not those of episodes"),
        ("tracking", with_cells(0, hota_association=[1.0]), "hota_association has 1 numbers"),
        ("tracking", lambda rows: rows + rows, r"tracking\.parquet: row 7 .*: is there twice"),
        ("tracking", lambda rows: rows[1:], "its episodes, .* are not those of episodes.parquet"),
        ("frames", lambda rows: rows + rows, r"frames\.parquet: row 217 .*: is there twice"),
        ("frames", with_cells(4, visible_left=1.5), "row 5 .*visible_left is 1.5, not within 0..1"),
        ("frames", with_cells(4, scenario="other"), "row 5 .*is of no episode of this run"),
        ("frames", with_cells(4, status="asleep"), "status must be of waiting, tracked"),
        ("events", with_cells(0, last_frame=2), "first_frame is 5, more than last_frame, 2"),
        ("events", with_cells(0, kind="x"), "kind must be of swap"),
        ("cameras", with_cells(0, K=[1.0]), "K has 1 numbers, not 9"),
        ("detections", with_cells(0, seed=-1), "seed is -1, not within"),
    ],
)
def test_a_row_that_cannot_be_is_named(run, name, change, message):
    rewritten(run, name, change)
    with pytest.raises(BenchError, match=message) as caught:
        load(run)
    assert f"{name}.parquet" in str(caught.value) or "run.json" in str(caught.value)


def test_a_table_of_too_many_cells_is_refused_before_it_is_unpacked(run, monkeypatch):
    monkeypatch.setattr("sim.parquet.MAX_CELLS", 200_000)
    path = run / "events.parquet"
    schema = pq.read_schema(path)
    constant = {"string": "x", "int64": 0, "double": 0.0, "bool": False}
    columns = [pa.repeat(pa.scalar(constant[str(c.type)], c.type), 30_000) for c in schema]
    pq.write_table(pa.table(columns, schema=schema), path, compression="zstd")
    assert path.stat().st_size < 10_000
    with_checksum(run, path)
    with pytest.raises(BenchError, match=r"events\.parquet: has more than 200000 cells"):
        load(run)


def test_long_texts_repeated_are_refused_before_they_are_unpacked(run, monkeypatch):
    monkeypatch.setattr("sim.parquet.MAX_TEXT_BYTES", 8 << 20)
    long = "x" * 100_000
    rewritten(run, "detections", lambda rows: [{**row, "scenario": long} for row in rows[:100]])
    assert (run / "detections.parquet").stat().st_size < 1_000_000
    with pytest.raises(BenchError, match="has more than 8 MiB in column 'scenario'"):
        load(run)


def test_a_film_that_unpacks_to_gigabytes_is_refused_before(run, monkeypatch):
    monkeypatch.setattr("reports.run.load.MAX_FILM_BYTES", 8 << 20)
    read = load(run)
    file = read.meta["films"][0]["file"]
    with zipfile.ZipFile(run / file, "w", zipfile.ZIP_DEFLATED) as film:
        for frame in range(5):
            film.writestr(f"{frame}.webp", bytes(2 << 20))
    with pytest.raises(BenchError, match=r"is damaged: is larger than 8 MiB unpacked"):
        read_film(read, file)
