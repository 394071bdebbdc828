"""What every export keeps to."""

import json
import shutil
from dataclasses import replace
from functools import partial

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from worker_tasks import killed_while_it_writes

import sim.dataset
from pjpdaf.errors import BenchError, InfrastructureError
from sim.dataset.export.export import PARTS
from sim.dataset.export.registry import EXPORTS
from sim.dataset.files import layout
from sim.dataset.files.layout import LABELS
from sim.processes import WorkerPool

KEPT = ("seg", "amodal", "disparity")


@pytest.fixture(params=sorted(EXPORTS))
def export(request):
    return EXPORTS[request.param]


@pytest.fixture
def dataset_small(dataset_made, tmp_path):
    """A copy with few labels."""
    folder = tmp_path / "small"
    dropped = [name for label in LABELS if label not in KEPT for name in LABELS[label]]
    shutil.copytree(dataset_made, folder, ignore=shutil.ignore_patterns(*dropped))
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["settings"]["labels"] = list(KEPT)
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_same_bytes_again_and_an_older_export_is_replaced(export, dataset_small, tmp_path):
    dataset, done = sim.dataset.open(dataset_small), []
    (out := tmp_path / "out").mkdir()
    written = export(dataset, out, done.append)
    assert done == [sequence.name for sequence in dataset.sequences]
    first = contents(out)
    assert sorted(out / path for path in first) == written == sorted(written)
    (written[0].parent / "older.txt").write_text("of another version")
    assert export(sim.dataset.open(dataset_small), out) == written
    assert contents(out) == first


def test_the_command_line_knows_the_formats():
    assert tuple(EXPORTS) == layout.EXPORTS
    assert set(layout.EXPORTS_NEED) < set(EXPORTS)


@pytest.fixture(scope="module")
def pool():
    with WorkerPool(2) as workers:
        yield workers


def test_workers_write_the_same_bytes(export, dataset_small, tmp_path, pool):
    dataset, done = sim.dataset.open(dataset_small), []
    for name in ("alone", "workers"):
        (tmp_path / name).mkdir()
    alone = export(dataset, tmp_path / "alone")
    written = export(dataset, tmp_path / "workers", done.append, pool)
    assert done == [sequence.name for sequence in dataset.sequences]  # in order
    assert len(written) == len(alone)
    assert contents(tmp_path / "workers") == contents(tmp_path / "alone")
    assert PARTS not in {part for path in written for part in path.parts}


def test_of_several_damaged_sequences_the_first_is_named(dataset_small, pool):
    for name in ("seq_000001", "seq_000002"):
        (dataset_small / name / "truth.parquet").write_bytes(b"no table")
    for workers in (None, pool):
        with pytest.raises(BenchError, match=r"seq_000001/truth\.parquet: "):
            EXPORTS["coco"](sim.dataset.open(dataset_small), dataset_small, pool=workers)
    assert not list(dataset_small.glob(".part-*"))


def test_a_format_whose_label_is_missing_is_one_line(dataset_small):
    dataset = sim.dataset.open(dataset_small)
    dataset.manifest["settings"]["labels"] = ["amodal"]
    for name, label in layout.EXPORTS_NEED.items():
        with pytest.raises(BenchError, match=f"has no label {label}, of which .* are made"):
            EXPORTS[name](dataset, dataset_small)


def test_the_part_of_a_killed_worker_is_written_again(dataset_made, tmp_path, pool):
    """Its half of a part is removed first; where every attempt ends so, a line says it."""
    dataset, mot = sim.dataset.open(dataset_made), EXPORTS["mot"]

    def written(often):
        (folder := tmp_path / str(often)).mkdir()
        write = partial(killed_while_it_writes, tmp_path / f"mark{often}", often, mot.write)
        replace(mot, write=write)(dataset, folder, pool=pool)
        return contents(folder)

    assert written(2) == written(0)
    with pytest.raises(InfrastructureError, match=r"seq_000001: its worker process died 3 times"):
        written(3)
    assert not list((tmp_path / "3").iterdir())


@pytest.mark.sample(3)  # all are written by one function
def test_what_a_killed_export_left_is_removed(export, dataset_small, tmp_path):
    dataset = sim.dataset.open(dataset_small)
    (out := tmp_path / "out").mkdir()
    name = export(dataset, out)[0].relative_to(out).parts[0]
    for left in (f".part-{name}", f".part-old-{name}"):
        (out / left / "gt").mkdir(parents=True)
    export(dataset, out)
    assert [path.name for path in out.iterdir()] == [name]


FAULTS = {
    "order": {"target": "head"},
    "length": {"keypoints_left_px": [[1.0, 2.0]]},
    "box": {"visible_left_px": 0},
    "number": {"z_m": float("inf")},
    "none": {"time_s": None},
}


FEW_FAULTS = ("length",)  # the others, which the same check of the tables finds, with `-m long`


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(fault, marks=() if fault in FEW_FAULTS else (pytest.mark.long,))
        for fault in sorted(FAULTS)
    ],
)
def test_a_damaged_table_is_named_and_the_older_export_stays(export, fault, dataset_small):
    dataset = sim.dataset.open(dataset_small)
    export(dataset, dataset_small)
    before = contents(dataset_small)
    path = dataset_small / "seq_000001" / "truth.parquet"
    sound = path.read_bytes()
    rows = pq.read_table(path).to_pylist()
    rows[4] |= FAULTS[fault]
    pq.write_table(pa.Table.from_pylist(rows, schema=pq.read_schema(path)), path)
    with pytest.raises(BenchError, match=r"seq_000001/truth\.parquet: "):
        export(dataset, dataset_small)
    path.write_bytes(sound)
    assert contents(dataset_small) == before
