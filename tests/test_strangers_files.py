"""Every reader of files against files of strangers: a fault is one line, and nothing else happens.

Never a traceback, a hang, a gigabyte, or a file outside the folder. Some examples of each reader
here; `-m long` runs many.
"""

from __future__ import annotations

import json
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import damaged_bytes, damaged_json, damaged_table, damaged_text
from rendered_boards import example_rig
from small_dataset import dataset_made

import sim.dataset
from pjpdaf.calibration import read_rig, write_rig
from pjpdaf.errors import BenchError
from pjpdaf.sources import stereo_frames
from reports.run.load import load, read_film
from reports.summary.tables import summarise
from scenarios.play.recipe import read_recipe
from scenarios.spec.loader import load_either_file
from scenarios.tables.detections import read_detections
from scenarios.tracks.files import read_tracks
from sim.clips.clip_files import load_clip
from sim.dataset.files.checksums import sha256_of
from sim.dataset.files.reading import read_json
from tests.pjpdaf.test_calibration_formats import kalibr, ros
from tests.sim.clips.test_bvh import bvh

__all__ = ["dataset_made"]

ROOT = Path(__file__).parents[1]
FEW, MANY = 40, 1500
LIMIT_S = 20  # of one file
MEMORY_MB = 1000  # above what the process has before
ACCEPTED = ROOT / "reports/accepted/smoke-thesis"


class TooSlow(Exception):
    """A reader that hangs."""


@contextmanager
def bounded(folder: Path) -> Iterator[None]:
    """Fail where the block takes too long, too much memory, or opens a file outside to write."""

    def late(number, frame):
        raise TooSlow(f"no answer within {LIMIT_S} s")

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    handler = signal.signal(signal.SIGALRM, late)
    signal.alarm(LIMIT_S)
    _watched.append(str(folder))
    try:
        yield
    finally:
        _watched.clear()
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
    assert (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10) - before < MEMORY_MB
    assert not _written, _written


_watched: list[str] = []
_written: list[str] = []


def _audit(event: str, arguments: tuple) -> None:
    if event == "open" and _watched:
        path, mode, flags = arguments
        writes = (isinstance(mode, str) and set(mode) & set("wax+")) or (flags or 0) & 0o3
        own = isinstance(path, int) or str(path).startswith((_watched[0], "/dev/"))
        if writes and not own and ".hypothesis" not in str(path):
            _written.append(str(path))


sys.addaudithook(_audit)


def one_line(read: Callable[[], object], folder: Path) -> None:
    """Read; a fault must be a BenchError of one printable line."""
    with bounded(folder):
        try:
            read()
        except BenchError as fault:
            line = str(fault)
            assert line.isprintable(), line
            assert len(line) < 3000


COMMON = {
    "deadline": None,
    "derandomize": True,
    "database": None,
    "suppress_health_check": list(HealthCheck),
}
COUNTS = [
    pytest.param(FEW, id="few"),
    pytest.param(MANY, id="many", marks=pytest.mark.long),
]


def fuzz(count: int, strategy, check: Callable[[object], None]) -> None:
    """Run a check on `count` examples; says how many and how long."""
    number = 0

    @settings(max_examples=count, **COMMON)
    @given(strategy)
    def run(example):
        nonlocal number
        number += 1
        check(example)

    wall, cpu = time.perf_counter(), time.process_time()
    run()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"{number} files in {wall:.1f} s, {cpu:.1f} s of CPU")


@pytest.mark.parametrize("count", COUNTS)
def test_scenarios_and_suites(count, tmp_path):
    texts = [
        (ROOT / f"scenarios/{name}.yaml").read_text()
        for name in ("catalog/cross", "catalog/recorded", "suites/smoke", "suites/core")
    ]
    file = tmp_path / "mine.yaml"

    def check(content):
        file.write_bytes(content)
        one_line(lambda: load_either_file(file), tmp_path)

    fuzz(count, st.sampled_from(texts).flatmap(damaged_text), check)


@pytest.fixture(scope="module")
def recipe_text():
    from scenarios.play.job import Job, System
    from scenarios.play.recipe import Recipe, SequenceSettings
    from scenarios.spec.names import load_scenario

    job = Job(load_scenario("cross"), 3, {"frames": 5, "speed": "0.3 m/s"}, System())
    return json.dumps(Recipe(job, SequenceSettings(("seg",), (320, 240))).record(0))


@pytest.mark.parametrize("count", COUNTS)
def test_recipes(count, tmp_path, recipe_text):
    def check(content):
        (tmp_path / "recipe.json").write_bytes(content)
        path = tmp_path / "recipe.json"
        one_line(lambda: read_recipe(read_json(path), tmp_path), tmp_path)

    fuzz(count, damaged_json(recipe_text), check)


@pytest.mark.parametrize("count", COUNTS)
def test_calibrations(count, tmp_path):
    inner, outer = write_rig(example_rig(), tmp_path)
    ways = {inner: (tmp_path,), outer: (tmp_path,)}
    pair = ros(tmp_path, example_rig())
    chain = kalibr(tmp_path, example_rig())
    ways |= {pair[0]: pair, pair[1]: pair, chain: (chain,)}
    texts = {file: file.read_text() for file in ways}
    cases = st.sampled_from(list(ways)).flatmap(
        lambda file: st.tuples(st.just(file), damaged_text(texts[file]))
    )

    def check(case):
        file, content = case
        file.write_bytes(content)
        one_line(lambda: read_rig(*ways[file]), tmp_path)
        file.write_text(texts[file])

    fuzz(count, cases, check)


@pytest.mark.parametrize("count", COUNTS)
def test_clips(count, tmp_path):
    csv = (ROOT / "scenarios/catalog/clips/story.csv").read_text()[:6000]
    clip = load_clip(ROOT / "scenarios/catalog/clips/story.csv")
    np.savez(
        tmp_path / "whole.npz",
        t=clip.times_s[:40],
        joints=np.array(["lhand", "rhand"]),
        xyz=np.stack([clip.path("left_hand"), clip.path("right_hand")], axis=1)[:40],
    )
    npz = (tmp_path / "whole.npz").read_bytes()
    cases = st.one_of(
        st.tuples(st.just("csv"), damaged_text(csv)),
        st.tuples(st.just("bvh"), damaged_text(bvh(n=12))),
        st.tuples(st.just("npz"), damaged_bytes(npz)),
    )

    def check(case):
        file = tmp_path / f"mine.{case[0]}"
        file.write_bytes(case[1])
        one_line(lambda: load_clip(file), tmp_path)

    fuzz(count, cases, check)


TRACKS = "frame,target,x_m,y_m,z_m,status,sd_x_m,sd_y_m,sd_z_m,exchange_probability\n" + "".join(
    f"{f},{t},0.{f},0.1,1.2,tracked,0.01,0.01,0.02,{'' if t == 'head' else '0.1'}\n"
    for f in range(6)
    for t in ("head", "right_hand", "left_hand")
)
DETECTIONS = "frame,view,u_px,v_px,sd_px,area_px,score\n" + "".join(
    f"{f},{v},{100 + f},{50 + f}.5,2,900,0.8\n" for f in range(6) for v in ("left", "right")
)


@pytest.mark.parametrize("count", COUNTS)
def test_tracks_and_detections(count, tmp_path):
    from io import BytesIO

    import pandas as pd

    tables = {}
    for name, text in (("tracks", TRACKS), ("detections", DETECTIONS)):
        tables[name] = tmp_path / f"{name}_whole.parquet"
        pd.read_csv(BytesIO(text.encode())).to_parquet(tables[name])
    cameras = example_rig().cameras
    reads = {
        "tracks": lambda file: read_tracks(file, {"one": 6}),
        "detections": lambda file: read_detections(file, {"one": cameras}, {"one": 6}),
    }

    def case(name):
        text = TRACKS if name == "tracks" else DETECTIONS
        whole = tables[name].read_bytes()
        return st.one_of(
            st.tuples(st.just(name), st.just("csv"), damaged_text(text)),
            st.tuples(st.just(name), st.just("parquet"), damaged_bytes(whole)),
            st.tuples(st.just(name), st.just("table"), damaged_table(tables[name])),
        )

    def check(drawn):
        name, kind, content = drawn
        file = tmp_path / f"mine.{'csv' if kind == 'csv' else 'parquet'}"
        if kind == "table":
            pq.write_table(content, file)
        else:
            file.write_bytes(content)
        one_line(lambda: reads[name](file), tmp_path)

    fuzz(count, st.sampled_from(sorted(reads)).flatmap(case), check)


@pytest.mark.parametrize("count", COUNTS)
def test_saved_runs(count, tmp_path):
    run = tmp_path / "run"
    run.mkdir()
    whole = {file.name: file.read_bytes() for file in ACCEPTED.iterdir()}
    tables = sorted(name for name in whole if name.endswith(".parquet"))
    meta = whole["run.json"].decode()

    def case(name):
        if name == "run.json":
            return st.tuples(st.just(name), damaged_json(meta))
        return st.one_of(
            st.tuples(st.just(name), damaged_table(ACCEPTED / name)),
            st.tuples(st.just(name), damaged_bytes(whole[name])),
        )

    def check(drawn):
        name, content = drawn
        for file, data in whole.items():
            (run / file).write_bytes(data)
        if isinstance(content, bytes):
            (run / name).write_bytes(content)
        else:
            pq.write_table(content, run / name)
        if name != "run.json":  # with its checksum made anew
            changed = json.loads(meta)
            changed["files"][name]["sha256"] = sha256_of(run / name)
            (run / "run.json").write_text(json.dumps(changed))
        one_line(lambda: summarise(load(run)), run)

    fuzz(count, st.sampled_from(["run.json", *tables]).flatmap(case), check)


@pytest.mark.parametrize("count", [pytest.param(8, id="few"), COUNTS[1]])
def test_data_sets(count, dataset_made, tmp_path):
    sequence = "seq_000000"
    names = [
        str(file.relative_to(dataset_made))
        for file in sorted(dataset_made.rglob("*"))
        if file.suffix in (".json", ".parquet", ".yml", ".csv") and "seq_00000" in str(file)
    ]
    names = [n for n in names if n.startswith(sequence)] + ["manifest.json"]
    folder = tmp_path / "set"

    def case(name):
        file = dataset_made / name
        if name.endswith(".json"):
            return st.tuples(st.just(name), damaged_json(file.read_text()))
        if name.endswith(".parquet"):
            return st.one_of(
                st.tuples(st.just(name), damaged_table(file)),
                st.tuples(st.just(name), damaged_bytes(file.read_bytes())),
            )
        return st.tuples(st.just(name), damaged_text(file.read_text()))

    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes((dataset_made / name).read_bytes())
    for side in ("left", "right"):
        (folder / sequence / side).symlink_to(dataset_made / sequence / side)

    def read_all():
        for one in sim.dataset.open(folder).sequences:
            for part in ("frame_count", "truths", "calibration", "rig", "recipe", "fps"):
                getattr(one, part)
            read_recipe(one.recipe, one.folder)

    def check(drawn):
        name, content = drawn
        if isinstance(content, bytes):
            (folder / name).write_bytes(content)
        else:
            pq.write_table(content, folder / name)
        one_line(read_all, folder)
        (folder / name).write_bytes((dataset_made / name).read_bytes())

    fuzz(count, st.sampled_from(names).flatmap(case), check)


@pytest.mark.parametrize("count", COUNTS)
def test_pictures_and_videos(count, tmp_path):
    rng = np.random.default_rng(0)
    picture = cv2.resize(rng.integers(0, 255, (6, 8, 3)).astype(np.uint8), (64, 48))
    contents = {
        suffix: cv2.imencode(suffix, picture)[1].tobytes() for suffix in (".png", ".jpg", ".bmp")
    }
    film = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter_fourcc(*"MJPG"), 5.0, (64, 48))
    for _ in range(4):
        writer.write(picture)
    writer.release()
    contents[".avi"] = film.read_bytes()
    folder = tmp_path / "view"
    folder.mkdir()
    cases = st.sampled_from(sorted(contents)).flatmap(
        lambda suffix: st.tuples(st.just(suffix), damaged_bytes(contents[suffix]))
    )

    def check(case):
        suffix, content = case
        if suffix == ".avi":
            source = tmp_path / "mine.avi"
            source.write_bytes(content)
        else:
            source = folder
            for file in folder.iterdir():
                file.unlink()
            (folder / f"0{suffix}").write_bytes(content)
            (folder / f"1{suffix}").write_bytes(contents[suffix])
        one_line(lambda: sum(1 for _ in stereo_frames(source, source)), tmp_path)

    fuzz(count, cases, check)


@pytest.mark.parametrize("count", COUNTS)
def test_films(count, tmp_path):
    import zipfile

    class Run:
        folder = tmp_path

    with zipfile.ZipFile(tmp_path / "whole.zip", "w") as archive:
        for k in range(3):
            archive.writestr(f"{k:05d}.webp", b"RIFF" * 20)
    whole = (tmp_path / "whole.zip").read_bytes()

    def check(content):
        (tmp_path / "film.zip").write_bytes(content)
        one_line(lambda: read_film(Run(), "film.zip"), tmp_path)

    fuzz(count, damaged_bytes(whole), check)


def test_the_checks_can_fail(tmp_path, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "LIMIT_S", 1)
    with pytest.raises(TooSlow), bounded(tmp_path):
        time.sleep(30)
    with pytest.raises(AssertionError), bounded(tmp_path), tempfile.TemporaryFile("w"):
        pass
    _written.clear()
    with pytest.raises(KeyError):
        one_line(lambda: {}["x"], tmp_path)
