"""croissant.json: the data set described in MLCommons Croissant 1.0 (JSON-LD)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sim.dataset.croissant_fields import record_set_of_pictures, record_set_of_table
from sim.dataset.files.checksums import sha256_of
from sim.dataset.files.layout import CONVENTIONS, LABELS, OBJECTS, SKELETON, TRUTH
from sim.dataset.files.tables import OBJECTS_SCHEMA, SKELETON_SCHEMA, TRUTH_SCHEMA
from sim.dataset.reader import Dataset
from sim.scene.world import CAMERAS

CROISSANT = "croissant.json"
CONFORMS_TO = "http://mlcommons.org/croissant/1.0"
LICENCE_URL = "https://creativecommons.org/licenses/by/4.0/"
NAME = "Head and hands in stereo"
DESCRIPTION = (
    "Rendered stereo sequences of a seated person, with exact labels of the head and both hands in "
    "every frame and view: depth, instance and amodal masks, boxes, keypoints, hand joints, "
    "positions, velocities, disparity."
)
CITATION = "The pjpdaf-bench authors: {name}, made with pjpdaf-bench {version}. CC BY 4.0."
# The context of JSON-LD, as the standard gives it in appendix 1.
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


def croissant_record(dataset: Dataset) -> dict[str, Any]:
    """The content of croissant.json, with the SHA-256 of single files.

    Without the manifest and the card, which are written last. Raises OSError.
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
            _file_set(
                "skeleton-tables", "A row a frame and skeleton", f"seq_*/{SKELETON}", PARQUET
            ),
            *(
                _file_set(f"pictures-{folder}", text, f"seq_*/{folder}/*.png", "image/png")
                for folder, text in folders.items()
            ),
        ],
        "recordSet": [
            record_set_of_table(
                "truth", "truth-tables", "The exact truth: a row a frame and target", TRUTH_SCHEMA
            ),
            record_set_of_table(
                "objects", "object-tables", "The objects: a row a frame and object", OBJECTS_SCHEMA
            ),
            record_set_of_table(
                "skeletons",
                "skeleton-tables",
                "Joints of both hands and points of the upper body: a row a frame and skeleton",
                SKELETON_SCHEMA,
            ),
            *(record_set_of_pictures(folder, text) for folder, text in folders.items()),
        ],
    }


def versions_of(dataset: Dataset) -> Mapping[str, Any]:
    """Versions in the manifest of the software that made a data set."""
    made_with = dataset.manifest.get("made_with")
    versions = made_with.get("versions") if isinstance(made_with, Mapping) else None
    return versions if isinstance(versions, Mapping) else {}


def _folders(dataset: Dataset) -> dict[str, str]:
    """Folders of PNG pictures in a sequence, with their descriptions."""
    folders = {view: f"What the {view} camera filmed" for view in CAMERAS}
    for label in dataset.labels:
        for folder in LABELS.get(label, ()):
            kind, _, view = folder.rpartition("_")
            if kind != "float":  # NPZ
                title = kind.replace("_", " ").capitalize()
                folders[folder] = f"{title} of the {view} view; {CONVENTIONS} says how"
    return folders


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


def _file_set(identity: str, description: str, includes: str, kind: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": identity,
        "name": identity,
        "description": description,
        "encodingFormat": kind,
        "includes": includes,
    }
