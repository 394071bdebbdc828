"""COCO's instances files against the numbers of the sequences."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from sim.dataset.check.exports.numbers import SequenceNumbers
from sim.dataset.check.exports.run_lengths import run_lengths
from sim.dataset.check.fault import MISSING, Fault, FaultLog
from sim.dataset.check.files import FileTree
from sim.dataset.files.layout import picture_name
from sim.dataset.files.reading import MAX_JSON_BYTES, read_json
from sim.dataset.labels.instances import PERSON
from sim.dataset.labels.records import BODY_SKELETON
from sim.scene.world import CAMERAS

FOLDER = "annotations"
SHARE, STAMP_S, CENTROID_PX, KEYPOINT_PX = 1e-6, 1e-9, 1e-6, 6e-4  # to which they are written
_SKELETON_OF = (*TARGETS, BODY_SKELETON)  # by track, from 1
_COMPARED = (
    *("image_id", "track_id", "bbox", "area", "segmentation"),
    *("visible_fraction", "keypoints", "num_keypoints"),
)

Record = dict[str, Any]
ImageKey = tuple[str, int]  # sequence, frame index


def check_coco(
    tree: FileTree, sequences: Mapping[str, SequenceNumbers | None], log: FaultLog
) -> None:
    """Check both views' files. sequences: numbers by name, None is not compared."""
    for view, camera in enumerate(CAMERAS):
        file = f"{FOLDER}/instances_{camera}.json"
        if file not in tree.plain:
            log.add("coco", [Fault(file, MISSING)])
            continue
        faults: list[Fault] = []
        try:
            content = log.read(partial(_read, tree.root / file))
            if content is not None:
                for fault in _file_faults(file, view, *content, sequences):
                    faults.append(fault)  # noqa: PERF402 (those before an exception count)
        except (KeyError, TypeError, ValueError, IndexError) as error:
            text = f"is not COCO's instances as this data set has them: {error!r}"
            faults.append(Fault(file, text))
        log.add("coco", faults)


def _read(path: Path) -> tuple[list[Record], list[Record]]:
    """Images and annotations of a file; line by line where it is too large to be read at once."""
    if path.stat().st_size <= MAX_JSON_BYTES:
        record = read_json(path)
        return record["images"], record["annotations"]
    images, annotations = [], []
    with path.open(encoding="utf-8") as lines:
        for line in lines:
            if line.startswith('{"id"'):
                record = json.loads(line.rstrip(",\n"))
                if "image_id" in record:
                    annotations.append({key: record[key] for key in _COMPARED if key in record})
                else:
                    images.append(record)
    return images, annotations


def _file_faults(
    file: str,
    view: int,
    images: list[Record],
    annotations: list[Record],
    sequences: Mapping[str, SequenceNumbers | None],
) -> Iterator[Fault]:
    tracks: dict[ImageKey, dict[int, Record]] = {}
    keys: dict[int, ImageKey] = {}
    for image in images:
        key = image["sequence"], image["frame_index"]
        keys[image["id"]], tracks[key] = key, {}
        numbers = sequences.get(key[0])
        if key[0] not in sequences:
            yield Fault(file, f"has a picture of {key[0]}, which is not there")
        if numbers is None:
            continue
        name = f"{key[0]}/{CAMERAS[view]}/{picture_name(key[1])}"
        stamp_s = numbers.stamps_s[key[1]]
        size = image["width"], image["height"]
        if image["file_name"] != name or size != numbers.size_px:
            yield Fault(file, f"its picture {name} has another name or size")
        if not abs(image["timestamp_s"] - stamp_s) <= STAMP_S:
            yield Fault(file, f"{name}: timestamp_s is not stamp_s of truth.parquet")
    for annotation in annotations:
        if annotation["image_id"] not in keys:
            yield Fault(file, f"has an annotation of the unknown image {annotation['image_id']}")
            continue
        tracks[keys[annotation["image_id"]]][annotation["track_id"]] = annotation
    for numbers in filter(None, sequences.values()):
        yield from _sequence_faults(file, view, numbers, tracks)


def _sequence_faults(
    file: str,
    view: int,
    numbers: SequenceNumbers,
    tracks: Mapping[ImageKey, Mapping[int, Record]],
) -> Iterator[Fault]:
    """The first fault of each kind in a sequence, with the number of others."""
    kinds: dict[str, list[str]] = {}
    for index, arrived in enumerate(numbers.arrived[:, view]):
        picture = f"{numbers.name}/{CAMERAS[view]}/{picture_name(index)}"
        annotations = tracks.get((numbers.name, index))
        if annotations is None or not arrived:
            if arrived or annotations is not None:
                text = "has no image" if arrived else "has an image, it did not arrive"
                kinds.setdefault("images", []).append(f"{picture} {text}")
            continue
        visible = {1 + t for t in range(len(TARGETS)) if numbers.visible_px[view, index, t]}
        visible |= {
            number
            for o, number in enumerate(numbers.object_ids)
            if numbers.objects_px[view, index, o]
        }
        if PERSON in annotations or visible & set(range(1, PERSON)):
            visible.add(PERSON)  # its clothes may show alone
        if set(annotations) != visible:
            text = f"{picture} has the tracks {sorted(annotations)}, the masks {sorted(visible)}"
            kinds.setdefault("annotations", []).append(text)
        for number in sorted(set(annotations) & visible):
            for kind, text in _annotation_faults(annotations[number], number, numbers, view, index):
                kinds.setdefault(kind, []).append(f"{picture}, track {number}: {text}")
    for kind, texts in kinds.items():
        more = f" (and {len(texts) - 1} more)" if len(texts) > 1 else ""
        yield Fault(file, f"{kind}: {texts[0]}{more}")


def _annotation_faults(
    annotation: Record, number: int, numbers: SequenceNumbers, view: int, index: int
) -> Iterator[tuple[str, str]]:
    """Kind and text of each fault of an annotation. number: its instance id."""
    area, centroid, box = run_lengths(annotation["segmentation"], numbers.size_px)
    t = number - 1
    if number <= PERSON:
        yield from _point_faults(annotation, numbers.points[_SKELETON_OF[t]][view, index])
    if number == PERSON:  # no table has its pixels; those of head and hands are a part
        pixels, expected = area, box
        least = int(numbers.visible_px[view, index].sum())
        if area < least:
            yield "segmentation", f"has {area} pixels, head and hands have {least}"
    elif t < len(TARGETS):
        pixels = int(numbers.visible_px[view, index, t])
        expected = numbers.boxes_px[view, index, t]
        if np.abs(centroid - numbers.centroids_px[view, index, t]).max() > CENTROID_PX:
            yield "segmentation", "its centroid is not that of truth.parquet"
        share = numbers.fractions[view, index, t]
        if not abs(annotation["visible_fraction"] - share) <= SHARE:
            text = f"is {annotation['visible_fraction']}, truth.parquet has {share:.6g}"
            yield "visible_fraction", text
    else:
        pixels = int(numbers.objects_px[view, index, numbers.object_ids.index(number)])
        expected = box
    if area != pixels:
        yield "segmentation", f"has {area} pixels, the tables say {pixels}"
    if annotation["area"] != pixels:
        yield "area", f"is {annotation['area']}, the tables say {pixels}"
    stored = np.array(annotation["bbox"], np.float64)
    same = stored.shape == (4,) and np.array_equal(stored, expected)
    if not same or not np.array_equal(box, expected):
        text = " ".join(f"{v:g}" for v in expected)
        yield "bbox", f"is {annotation['bbox']}, it should be {text} (counted from 0)"


def _point_faults(annotation: Record, points: Floats) -> Iterator[tuple[str, str]]:
    """Compare keypoints with u, v, status (K, 3) of the tables; more keypoints are not labelled."""
    stored = np.array(annotation["keypoints"], np.float64).reshape(-1, 3)
    expected = np.zeros_like(stored)
    expected[: len(points)] = points[: len(stored)]
    if len(stored) < len(points) or np.abs(stored - expected).max() > KEYPOINT_PX:
        yield "keypoints", "are not those of the tables"
    if annotation["num_keypoints"] != np.count_nonzero(expected[:, 2]):
        yield "num_keypoints", f"is {annotation['num_keypoints']}"
