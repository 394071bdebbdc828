"""croissant.json: the data set in the words of MLCommons Croissant 1.0 (JSON-LD)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa

from sim.dataset.files.checksums import sha256_of
from sim.dataset.files.layout import CONVENTIONS, LABELS, OBJECTS, TRUTH
from sim.dataset.files.tables import OBJECTS_SCHEMA, TRUTH_SCHEMA
from sim.dataset.reader import Dataset
from sim.scene.world import CAMERAS

CROISSANT = "croissant.json"
CONFORMS_TO = "http://mlcommons.org/croissant/1.0"
LICENCE_URL = "https://creativecommons.org/licenses/by/4.0/"
NAME = "Head and hands in stereo"
DESCRIPTION = (
    "Rendered stereo sequences of a seated person, with exact labels of the head and both hands in "
    "every frame and view: depth, instance and amodal masks, boxes, keypoints, positions, "
    "velocities, disparity."
)
CITATION = "The pjpdaf-bench authors: {name}, made with pjpdaf-bench {version}. CC BY 4.0."
# What JSON-LD turns into what; given by the standard, appendix 1.
_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileProperty": "cr:fileProperty",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
PARQUET = "application/x-parquet"
_SEQUENCE = r".*(seq_\d{6}).*"
# Readers of Croissant turn a picture into RGB of 8 bits: of these they are given the file's name.
_SIXTEEN_BITS = ("depth", "disparity", "correspondence")
_NUMBER = r".*?(\d{6})\.png"


def croissant_record(dataset: Dataset) -> dict[str, Any]:
    """The content of croissant.json; single files get the SHA-256 that they have now.

    The manifest and the card are not among them: they are the last to be written. Raises OSError.
    """
    version = str(versions_of(dataset).get("pjpdaf-bench", "of an unknown version"))
    folders = _folders(dataset)
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        "name": NAME,
        "description": DESCRIPTION,
        "license": LICENCE_URL,
        "citeAs": CITATION.format(name=NAME, version=version),
        "version": f"{dataset.manifest['schema']}.0.0",
        "isLiveDataset": False,
        "keywords": ["stereo", "hands", "head", "tracking", "depth", "segmentation", "synthetic"],
        "distribution": [
            *_single_files(dataset.folder),
            _file_set("truth-tables", "A row a frame and target", f"seq_*/{TRUTH}", PARQUET),
            _file_set("object-tables", "A row a frame and object", f"seq_*/{OBJECTS}", PARQUET),
            *(
                _file_set(f"pictures-{folder}", what, f"seq_*/{folder}/*.png", "image/png")
                for folder, what in folders.items()
            ),
        ],
        "recordSet": [
            _table("truth", "The exact truth: a row a frame and target", TRUTH_SCHEMA),
            _table("objects", "The objects: a row a frame and object", OBJECTS_SCHEMA),
            *(_pictures(folder, what) for folder, what in folders.items()),
        ],
    }


def versions_of(dataset: Dataset) -> Mapping[str, Any]:
    """Versions that it was made with, as the manifest says."""
    made_with = dataset.manifest.get("made_with")
    found = made_with.get("versions") if isinstance(made_with, Mapping) else None
    return found if isinstance(found, Mapping) else {}


def _folders(dataset: Dataset) -> dict[str, str]:
    """Folders of PNG pictures in a sequence, and what they hold."""
    found = {view: f"What the {view} camera filmed" for view in CAMERAS}
    for label in dataset.labels:
        for folder in LABELS.get(label, ()):
            kind, _, view = folder.rpartition("_")
            if kind != "float":  # NPZ
                found[folder] = f"{kind.capitalize()} of the {view} view; {CONVENTIONS} says how"
    return found


def _single_files(folder: Path) -> list[dict[str, Any]]:
    paths = [folder / CONVENTIONS, *sorted((folder / "annotations").glob("*.json"))]
    return [
        {
            "@type": "cr:FileObject",
            "@id": path.relative_to(folder).as_posix(),
            "name": path.relative_to(folder).as_posix(),
            "contentUrl": path.relative_to(folder).as_posix(),
            "contentSize": f"{path.stat().st_size} B",
            "encodingFormat": "application/json",
            "sha256": sha256_of(path),
        }
        for path in paths
        if path.is_file()
    ]


def _file_set(identity: str, what: str, includes: str, kind: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": identity,
        "name": identity,
        "description": what,
        "encodingFormat": kind,
        "includes": includes,
    }


def _table(name: str, what: str, schema: pa.Schema) -> dict[str, Any]:
    """A record set of a table's columns, and the sequence that a row is of."""
    source = {"truth": "truth-tables", "objects": "object-tables"}[name]
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": what,
        "field": [
            _of_path(f"{name}/sequence", source, _SEQUENCE, "sc:Text"),
            *(_column(f"{name}/{column.name}", source, column) for column in schema),
        ],
    }


def _column(identity: str, source: str, column: pa.Field) -> dict[str, Any]:
    field: dict[str, Any] = {
        "@type": "cr:Field",
        "@id": identity,
        "name": identity.rpartition("/")[2],
    }
    kind = column.type
    if pa.types.is_list(kind):
        field["repeated"] = True
        kind = kind.value_type
    if pa.types.is_struct(kind):
        # A part of each entry of a list of records.
        field["subField"] = [
            {
                "@type": "cr:Field",
                "@id": f"{identity}/{part.name}",
                "name": part.name,
                "repeated": True,
                "dataType": _data_type(part.type),
                "source": {
                    "fileSet": {"@id": source},
                    "extract": {"column": column.name},
                    "transform": {"jsonPath": part.name},
                },
            }
            for part in kind
        ]
        return field
    if pa.types.is_list(kind):  # points: the standard knows one level
        kind = kind.value_type
    field["dataType"] = _data_type(kind)
    field["source"] = {"fileSet": {"@id": source}, "extract": {"column": column.name}}
    return field


def _data_type(kind: pa.DataType) -> str:
    if pa.types.is_boolean(kind):
        return "sc:Boolean"
    if pa.types.is_integer(kind):
        return "sc:Integer"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"


def _pictures(folder: str, what: str) -> dict[str, Any]:
    source, name = f"pictures-{folder}", f"{folder}_pictures"
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": what,
        "field": [
            _of_path(f"{name}/sequence", source, _SEQUENCE, "sc:Text"),
            # Files count from 1; `frame_index` of the tables is one less.
            _of_path(f"{name}/file_number", source, _NUMBER, "sc:Integer"),
            _of_path(f"{name}/file", source, rf".*(seq_\d{{6}}/{folder}/\d{{6}}\.png)", "sc:Text")
            if folder.partition("_")[0] in _SIXTEEN_BITS
            else _content(f"{name}/picture", source),
        ],
    }


def _content(identity: str, source: str) -> dict[str, Any]:
    return {
        "@type": "cr:Field",
        "@id": identity,
        "name": identity.rpartition("/")[2],
        "dataType": "sc:ImageObject",
        "source": {"fileSet": {"@id": source}, "extract": {"fileProperty": "content"}},
    }


def _of_path(identity: str, source: str, regex: str, kind: str) -> dict[str, Any]:
    """A field that is a part of the file's path."""
    return {
        "@type": "cr:Field",
        "@id": identity,
        "name": identity.rpartition("/")[2],
        "dataType": kind,
        "source": {
            "fileSet": {"@id": source},
            "extract": {"fileProperty": "fullpath"},
            "transform": {"regex": regex},
        },
    }
