"""COCO's and MOTChallenge's files against the numbers of the sequences that they repeat."""

from __future__ import annotations

import configparser
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from sim.dataset.check.fault import MISSING, Fault, fault_of
from sim.dataset.check.files import Tree
from sim.dataset.check.frame_tables import Numbers
from sim.dataset.files.layout import picture_name
from sim.dataset.files.reading import MAX_JSON_BYTES, read_json
from sim.scene.world import CAMERAS

COCO, MOT = "annotations", "mot"
SHARE, METRES, STAMP_S = 1e-6, 1e-6, 1e-9  # to which they are written
CENTROID_PX = 1e-6

Held = Mapping[str, Numbers | None]
Record = dict[str, Any]


def export_faults(tree: Tree, held: Held) -> Iterator[Fault]:
    """Of the exports that are there. held: by sequence; None is not compared."""
    folders = {path.partition("/")[0] for path in tree.plain if "/" in path}
    if COCO in folders:
        for view, camera in enumerate(CAMERAS):
            file = f"{COCO}/instances_{camera}.json"
            if file not in tree.plain:
                yield Fault(file, MISSING)
                continue
            try:
                images, annotations = _coco(tree.root / file)
                yield from _coco_faults(file, view, images, annotations, held)
            except BenchError as error:
                yield fault_of(error, tree.root)
            except (KeyError, TypeError, ValueError, IndexError) as error:
                yield Fault(file, f"is not COCO's instances as this data set has them: {error!r}")
    if MOT in folders:
        for numbers in filter(None, held.values()):
            for view in range(len(CAMERAS)):
                yield from _mot_faults(tree, view, numbers)


def _coco(path: Path) -> tuple[list[Record], list[Record]]:
    """Its images and annotations; of a file too large to be taken whole, line by line."""
    if path.stat().st_size <= MAX_JSON_BYTES:
        record = read_json(path)
        return record["images"], record["annotations"]
    images, annotations = [], []
    with path.open(encoding="utf-8") as lines:
        for line in lines:
            if line.startswith('{"id"'):
                one = json.loads(line.rstrip(",\n"))
                if "image_id" in one:
                    annotations.append(_needed(one))
                else:
                    images.append(one)
    return images, annotations


def _needed(annotation: Record) -> Record:
    wanted = ("image_id", "track_id", "bbox", "area", "segmentation", "visible_fraction")
    return {key: annotation[key] for key in wanted if key in annotation}


def _coco_faults(
    file: str,
    view: int,
    images: list[dict[str, Any]],
    annotations: list[dict[str, Any]],
    held: Held,
) -> Iterator[Fault]:
    found: dict[tuple[str, int], dict[int, Record]] = {}
    places = {}
    for image in images:
        key = image["sequence"], image["frame_index"]
        places[image["id"]], found[key] = key, {}
        numbers = held.get(key[0])
        if key[0] not in held:
            yield Fault(file, f"has a picture of {key[0]}, which is not there")
        if numbers is None:
            continue
        wanted = f"{key[0]}/{CAMERAS[view]}/{picture_name(key[1])}"
        stamp_s = numbers.stamps_s[key[1]]
        size = image["width"], image["height"]
        if image["file_name"] != wanted or size != numbers.size_px:
            yield Fault(file, f"its picture {wanted} has another name or size")
        if not abs(image["timestamp_s"] - stamp_s) <= STAMP_S:
            yield Fault(file, f"{wanted}: timestamp_s is not stamp_s of truth.parquet")
    for one in annotations:
        if one["image_id"] not in places:
            yield Fault(file, f"has an annotation of the unknown image {one['image_id']}")
            continue
        found[places[one["image_id"]]][one["track_id"]] = one
    for numbers in filter(None, held.values()):
        yield from _coco_sequence(file, view, numbers, found)


def _coco_sequence(
    file: str,
    view: int,
    numbers: Numbers,
    found: Mapping[tuple[str, int], Mapping[int, Record]],
) -> Iterator[Fault]:
    """The first fault of each kind in a sequence, with how many more there are."""
    kinds: dict[str, list[str]] = {}
    for index, came in enumerate(numbers.arrived[:, view]):
        picture = f"{numbers.name}/{CAMERAS[view]}/{picture_name(index)}"
        mine = found.get((numbers.name, index))
        if mine is None or not came:
            if came or mine is not None:
                what = "has no image" if came else "has an image, it did not arrive"
                kinds.setdefault("images", []).append(f"{picture} {what}")
            continue
        shown = {1 + t for t in range(len(TARGETS)) if numbers.visible_px[view, index, t]}
        shown |= {
            number
            for o, number in enumerate(numbers.object_ids)
            if numbers.objects_px[view, index, o]
        }
        if set(mine) != shown:
            text = f"{picture} has the tracks {sorted(mine)}, the masks {sorted(shown)}"
            kinds.setdefault("annotations", []).append(text)
        for number in sorted(set(mine) & shown):
            for kind, what in _annotation(mine[number], number, numbers, view, index):
                kinds.setdefault(kind, []).append(f"{picture}, track {number}: {what}")
    for kind, said in kinds.items():
        more = f" (and {len(said) - 1} more)" if len(said) > 1 else ""
        yield Fault(file, f"{kind}: {said[0]}{more}")


def _annotation(
    one: Record, number: int, numbers: Numbers, view: int, index: int
) -> Iterator[tuple[str, str]]:
    area, centroid, box = run_lengths(one["segmentation"], numbers.size_px)
    t = number - 1
    if t < len(TARGETS):
        pixels = int(numbers.visible_px[view, index, t])
        wanted = numbers.boxes_px[view, index, t]
        if np.abs(centroid - numbers.centroids_px[view, index, t]).max() > CENTROID_PX:
            yield "segmentation", "its centroid is not that of truth.parquet"
        share = numbers.fractions[view, index, t]
        if not abs(one["visible_fraction"] - share) <= SHARE:
            what = f"is {one['visible_fraction']}, truth.parquet has {share:.6g}"
            yield "visible_fraction", what
    else:
        pixels = int(numbers.objects_px[view, index, numbers.object_ids.index(number)])
        wanted = box
    if area != pixels:
        yield "segmentation", f"has {area} pixels, the tables say {pixels}"
    if one["area"] != pixels:
        yield "area", f"is {one['area']}, the tables say {pixels}"
    said = np.array(one["bbox"], np.float64)
    if said.shape != (4,) or not np.array_equal(said, wanted) or not np.array_equal(box, wanted):
        text = " ".join(f"{v:g}" for v in wanted)
        yield "bbox", f"is {one['bbox']}, it should be {text} (counted from 0)"


def run_lengths(
    segmentation: Mapping[str, Any], size_px: tuple[int, int]
) -> tuple[int, Floats, Floats]:
    """Pixels, centroid (2,) and box (4,) of COCO's compressed mask of a picture (width, height).

    Raises ValueError where it is none.
    """
    width, height = size_px
    runs = _runs(segmentation["counts"])
    if list(segmentation["size"]) != [height, width] or runs.sum() != width * height:
        raise ValueError("a mask is not of the picture's size")
    ends = np.cumsum(runs)
    first, last = ends[:-1:2], ends[1::2]  # of the runs that are set, in columns one below another
    first = first[: len(last)]
    some = last > first
    first, last = first[some], last[some]
    if len(first) == 0:
        return 0, np.full(2, np.nan), np.full(4, np.nan)
    # A run that passes the lower end of a column is cut there.
    flat = np.repeat(first - np.append(0, np.cumsum(last - first)[:-1]), last - first)
    flat = flat + np.arange(len(flat))
    xs, ys = flat // height, flat % height
    low, high = (xs.min(), ys.min()), (xs.max(), ys.max())
    box = (*low, high[0] - low[0] + 1, high[1] - low[1] + 1)
    return len(flat), np.array([xs.mean(), ys.mean()]), np.array(box, np.float64)


def _runs(counts: str) -> NDArray[np.int64]:
    """COCO's text: 5 bits a character from 48 on, the sixth says that more follow; from the third
    run on the difference to the last but one.
    """
    runs: list[int] = []
    value = shift = 0
    for code in counts.encode("ascii"):
        bits = code - 48
        if not 0 <= bits < 64 or shift > 60:
            raise ValueError("a mask's counts are damaged")
        value |= (bits & 31) << shift
        shift += 5
        if not bits & 32:
            if bits & 16:
                value -= 1 << shift
            runs.append(value + (runs[-2] if len(runs) > 2 else 0))
            value = shift = 0
    found = np.array(runs, np.int64)
    if len(found) == 0 or found.min() < 0:
        raise ValueError("a mask's counts are damaged")
    return found


def _mot_faults(tree: Tree, view: int, numbers: Numbers) -> Iterator[Fault]:
    folder = f"{MOT}/{numbers.name}-{CAMERAS[view]}"
    info, boxes = f"{folder}/seqinfo.ini", f"{folder}/gt/gt.txt"
    places = f"{folder}/gt/gt_3d.txt"
    for file in (info, boxes, places):
        if file not in tree.plain:
            yield Fault(file, MISSING)
            return
    seen = {
        (index + 1, t + 1): np.array(
            [*(numbers.boxes_px[view, index, t] + (1, 1, 0, 0)), 1, 1, share]
        )
        for (index, t), share in np.ndenumerate(numbers.fractions[view])
        if numbers.arrived[index, view] and numbers.visible_px[view, index, t]
    }
    hidden = np.array([-1.0, -1, -1, -1, 0])
    there = {
        (index + 1, t + 1): np.append(
            seen[index + 1, t + 1][:5] if (index + 1, t + 1) in seen else hidden,
            numbers.centres_m[index, t],
        )
        for index, t in np.ndindex(numbers.centres_m.shape[:2])
    }
    yield from _lines_faults(tree.root, boxes, seen, 5)
    yield from _lines_faults(tree.root, places, there, 5)
    yield from _seqinfo_faults(tree.root, info, numbers)


def _lines_faults(
    root: Path, file: str, wanted: Mapping[tuple[int, int], Floats], exact: int
) -> Iterator[Fault]:
    """wanted: by frame and id, the numbers after them; `exact` of them are whole numbers."""
    try:
        text = (root / file).read_text(encoding="ascii")
        rows = [[float(word) for word in line.split(",")] for line in text.splitlines()]
        found = {(int(row[0]), int(row[1])): np.array(row[2:]) for row in rows}
    except (OSError, ValueError, IndexError) as error:
        yield Fault(file, f"is not MOTChallenge's ground truth: {error}")
        return
    if len(found) != len(rows) or set(found) != set(wanted):
        other = sorted(set(found) ^ set(wanted))
        which = f", first frame {other[0][0]}, id {other[0][1]}" if other else ""
        yield Fault(file, f"has {len(rows)} lines, {len(wanted)} are wanted{which}")
    wrong = []
    for key in sorted(set(found) & set(wanted)):
        mine, its = found[key], wanted[key]
        if mine.shape != its.shape or not (
            np.array_equal(mine[:exact], its[:exact])
            and np.abs(mine[exact:] - its[exact:]).max() <= METRES
        ):
            wrong.append(f"frame {key[0]}, id {key[1]}: {_text(mine)}; it should be {_text(its)}")
    if wrong:
        more = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
        yield Fault(file, f"{wrong[0]} (counted from 1){more}")


def _seqinfo_faults(root: Path, file: str, numbers: Numbers) -> Iterator[Fault]:
    wanted = {
        "seqlength": len(numbers.arrived),
        "framerate": numbers.fps,
        "imwidth": numbers.size_px[0],
        "imheight": numbers.size_px[1],
    }
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string((root / file).read_text(encoding="ascii"))
        said = {key: float(parser["Sequence"][key]) for key in wanted}
    except (OSError, ValueError, KeyError, configparser.Error) as error:
        yield Fault(file, f"is not MOTChallenge's seqinfo: {error!r}")
        return
    for key, value in wanted.items():
        if not abs(said[key] - value) <= 1e-4 * value:
            yield Fault(file, f"{key} is {said[key]:g}, the sequence has {value:g}")


def _text(values: Floats) -> str:
    return " ".join(f"{value:g}" for value in values.tolist())
