"""croissant.json: all that it names is there, of the right type, in one piece."""

import json
import re

import pyarrow.parquet as pq
import pytest

from sim.dataset.croissant import croissant_record
from sim.dataset.files.checksums import sha256_of
from sim.dataset.files.layout import CONVENTIONS
from sim.dataset.reader import open_dataset


@pytest.fixture
def record(dataset_copy):
    (dataset_copy / CONVENTIONS).write_text("{}")
    (dataset_copy / "annotations").mkdir()
    (dataset_copy / "annotations" / "instances_left.json").write_text("[]")
    return croissant_record(open_dataset(dataset_copy))


def fields_of(record):
    for one in record["recordSet"]:
        for field in one["field"]:
            yield from field.get("subField", [field])


def test_it_is_a_dataset_of_croissant_1_0(record):
    assert record["@type"] == "sc:Dataset"
    assert record["conformsTo"] == "http://mlcommons.org/croissant/1.0"
    for key in ("name", "description", "license", "citeAs", "version"):
        assert isinstance(record[key], str), key
        assert record[key], key
    assert record == json.loads(json.dumps(record, allow_nan=False))


def test_every_name_is_there_once(record):
    named = [one["@id"] for one in (*record["distribution"], *record["recordSet"])]
    named += [field["@id"] for one in record["recordSet"] for field in one["field"]]
    assert len(named) == len(set(named))
    for field in fields_of(record):
        assert field["source"]["fileSet"]["@id"] in named


def test_file_sets_find_files_and_single_files_have_their_sum(record, dataset_copy):
    single = [one for one in record["distribution"] if one["@type"] == "cr:FileObject"]
    assert [one["@id"] for one in single] == [CONVENTIONS, "annotations/instances_left.json"]
    for one in single:
        assert one["sha256"] == sha256_of(dataset_copy / one["contentUrl"])
    for one in record["distribution"]:
        if one["@type"] == "cr:FileSet":
            assert len(list(dataset_copy.glob(one["includes"]))) >= 3, one["includes"]


def test_fields_are_the_tables_columns_with_their_types(record, dataset_copy):
    sets = {one["@id"]: one for one in record["recordSet"]}
    for name in ("truth", "objects"):
        schema = pq.read_schema(dataset_copy / "seq_000000" / f"{name}.parquet")
        fields = {field["name"]: field for field in sets[name]["field"]}
        assert list(fields) == ["sequence", *schema.names]
        for column in schema:
            assert fields[column.name].get("repeated", False) == str(column.type).startswith("list")
    truth = {field["name"]: field for field in sets["truth"]["field"]}
    assert truth["x_m"]["dataType"] == truth["keypoints_m"]["dataType"] == "sc:Float"
    assert truth["arrived_left"]["dataType"] == "sc:Boolean"
    assert truth["visible_left_px"]["dataType"] == "sc:Integer"
    parts = truth["occluded_by_left"]["subField"]
    assert [part["dataType"] for part in parts] == ["sc:Text", "sc:Integer"]


def test_pictures_are_told_by_their_path(record):
    sets = {one["@id"]: one for one in record["recordSet"]}
    for folder, last in (("left", "picture"), ("seg_right", "picture"), ("depth_left", "file")):
        path = f"/any/where/seq_000002/{folder}/000005.png"
        fields = sets[f"{folder}_pictures"]["field"]
        assert fields[-1]["name"] == last
        found = [
            re.match(field["source"]["transform"]["regex"], path)[1]
            for field in fields
            if "transform" in field["source"]
        ]
        assert found[:2] == ["seq_000002", "000005"]
    # 16 bits would be lost where a reader makes RGB of them.
    assert found[2] == "seq_000002/depth_left/000005.png"
