"""What every export keeps to."""

import json
import shutil

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import sim.dataset
from pjpdaf.errors import BenchError
from sim.dataset.export.registry import EXPORTS
from sim.dataset.files.layout import LABELS

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


def test_same_bytes_again_and_an_older_export_is_replaced(export, dataset_made, tmp_path):
    dataset, done = sim.dataset.open(dataset_made), []
    written = export(dataset, tmp_path, done.append)
    assert done == [sequence.name for sequence in dataset.sequences]
    first = contents(tmp_path)
    assert sorted(tmp_path / path for path in first) == written == sorted(written)
    (written[0].parent / "older.txt").write_text("of another version")
    assert export(sim.dataset.open(dataset_made), tmp_path) == written
    assert contents(tmp_path) == first


def test_what_a_killed_export_left_is_removed(export, dataset_made, tmp_path):
    dataset = sim.dataset.open(dataset_made)
    name = export(dataset, tmp_path)[0].relative_to(tmp_path).parts[0]
    for left in (f".part-{name}", f".part-old-{name}"):
        (tmp_path / left / "gt").mkdir(parents=True)
    export(dataset, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]


FAULTS = {
    "order": {"target": "head"},
    "length": {"keypoints_left_px": [[1.0, 2.0]]},
    "box": {"visible_left_px": 0},
    "number": {"z_m": float("inf")},
    "none": {"time_s": None},
}


@pytest.mark.parametrize("fault", sorted(FAULTS))
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
