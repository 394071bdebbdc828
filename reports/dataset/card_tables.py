"""Front matter and tables of a data set's card."""

from __future__ import annotations

import io
from html import escape

from ruamel.yaml import YAML

from pjpdaf.targets import TARGETS
from reports.dataset.histograms import histogram_text
from sim.dataset.croissant import NAME
from sim.dataset.files.layout import (
    CALIBRATION,
    EVENTS,
    LABELS,
    OBJECTS,
    RECIPE,
    RIG,
    SKELETON,
    TRUTH,
)
from sim.dataset.reader import Dataset
from sim.dataset.statistics import Statistics
from sim.dataset.stored_sequence import StoredSequence

PICTURES, SAMPLE = "pictures", "sample.jpg"
IDENTITY = ("room", "body", "rig")  # of a sequence's recipe
LONG_TABLE = 24  # sequences; of more the table is by scenario
TASKS = ("object-detection", "image-segmentation", "depth-estimation", "keypoint-detection")
TAGS = ("stereo", "tracking", "hands", "head", "disparity", "synthetic", "mujoco")
# Of the rows of the truth, as the Hub counts.
_SIZES = (
    (1_000, "n<1K"),
    (10_000, "1K<n<10K"),
    (100_000, "10K<n<100K"),
    (1_000_000, "100K<n<1M"),
    (10_000_000, "1M<n<10M"),
)
_KINDS = {
    "clean": "8 bit, colour: the picture before the sensor's noise and blur",
    "depth": "16 bit: planar z in 0.1 mm, 0 = nothing",
    "seg": "8 bit: instance ids, named in `rig.json`",
    "amodal": "8 bit: the whole of each target, hidden parts too; bit 0 head, 1 right, 2 left hand",
    "disparity": "16 bit: disparity of the rectified pair x 256, 0 = none; `occlusion_*`: status",
    "correspondence": "16 bit, three channels: where a pixel's surface lies in the other view",
    "semantic": "8 bit: class of the surface (face, hair, wall, ...), as in `conventions.json`",
    "normals": "8 bit, three channels: surface normal in the camera's frame, 128 + 127 n",
    "flow": "16 bit, three channels: where a pixel's surface is in the next frame, the last",
    "float": "NPZ: the same numbers as float32, not rounded",
}

# Folders beside the sequences, where they were exported.
_BESIDE = {
    "annotations": "`annotations/`, masks, boxes and keypoints as COCO has them",
    "mot": "`mot/`, tracks as MOTChallenge has them",
    "webdataset": "`webdataset/`, pictures and labels by frame in tar files for WebDataset",
    "parquet": "`parquet/`, a row a frame, with both pictures",
    "yolo-pose": "`yolo-pose/`, the hands' joints as Ultralytics YOLO has them",
    "yolo-seg": "`yolo-seg/`, outlines of head and hands as Ultralytics YOLO has them",
    "middlebury": "`middlebury/`, rectified pairs and disparity as Middlebury has them",
    "hdf5": "`hdf5/`, pictures, labels and truth as arrays, a file a sequence",
}


def front_matter(statistics: Statistics) -> str:
    """The YAML that the Hub reads."""
    rows = statistics.frames * len(TARGETS)
    size = next((name for least, name in _SIZES if rows < least), "n>10M")
    configs: list[dict[str, object]] = [
        {"config_name": "truth", "data_files": f"seq_*/{TRUTH}", "default": True}
    ]
    configs.append({"config_name": "skeletons", "data_files": f"seq_*/{SKELETON}"})
    if statistics.object_rows:  # `datasets` loads no table without a row
        configs.append({"config_name": "objects", "data_files": f"seq_*/{OBJECTS}"})
    record = {
        "license": "cc-by-4.0",
        "pretty_name": NAME,
        "task_categories": list(TASKS),
        "size_categories": [size],
        "annotations_creators": ["machine-generated"],
        "tags": list(TAGS),
        "configs": configs,
    }
    yaml, stream = YAML(), io.StringIO()
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.dump(record, stream)
    return stream.getvalue()


def sequence_table(dataset: Dataset, statistics: Statistics) -> str:
    """A row per sequence; of many sequences a row per scenario."""
    if len(dataset.sequences) > LONG_TABLE:
        lines = [
            f"| {escaped(name)} | {sequences} | {frames} |"
            for name, (sequences, frames) in statistics.scenarios.items()
        ]
        head = "| scenario | sequences | frames |\n|---|--:|--:|"
        return "\n".join([head, *lines])
    lines = []
    for sequence in dataset.sequences:
        entry = sequence.entry
        cells = [str(entry.get(key, "")) for key in ("label", "scenario", "rung", "seed")]
        cells += [identity_part(sequence, part)[:8] for part in IDENTITY]
        lines.append(
            f"| {sequence.name} | {' | '.join(map(escaped, cells))} | {sequence.frame_count} "
            f"| {sequence.fps:g} |"
        )
    head = "| folder | label | scenario | rung | seed | room | body | rig | frames | frames/s |"
    return "\n".join([head, "|---|---|---|---|--:|---|---|---|--:|--:|", *lines])


def identity_part(sequence: StoredSequence, part: str) -> str:
    """The digest of "room", "body" or "rig" in a sequence's recipe; "" where it has none."""
    value = sequence.identity.get(part)
    return value if isinstance(value, str) else ""


def label_tables(statistics: Statistics) -> str:
    """Histograms, merges and keypoints of the labels."""
    pictures = [
        f'<img src="{PICTURES}/{name}.svg" width="460" '
        f'alt="{escape(f"{one.bins.title}. {histogram_text(one)}", quote=True)}">'
        for name, one in statistics.histograms.items()
    ]
    frames = max(statistics.frames, 1)
    merged = [
        f"| {escaped(pair.replace('_', ' '))} | {count} | {100 * count / frames:.1f} % |"
        for pair, count in statistics.merged.items()
    ]
    points = [
        f"| {name} | {visible} | {occluded} | {none} |"
        for name, (none, occluded, visible) in statistics.keypoints.items()
    ]
    lost = ", ".join(f"{view} {count}" for view, count in statistics.lost_pictures.items())
    return "\n".join(
        [
            "Visible share, truncation: a value a target, view and frame. Distance, way, speed: a "
            "value a target and frame. The first and the last bar hold what lies beyond them too.",
            "",
            "\n".join(pictures),
            "",
            f"Merged (visible skin is one blob) in any view: {statistics.merged_frames} of "
            f"{statistics.frames} frames. Both hands one blob in both views: "
            f"{statistics.ambiguous_frames}. Lost pictures: {lost}.",
            "",
            "| merged, view | frames | share |",
            "|---|--:|--:|",
            *merged,
            "",
            "<details><summary>Keypoints, over both views</summary>",
            "",
            "| keypoint | visible | occluded | outside the picture |",
            "|---|--:|--:|--:|",
            *points,
            "",
            "</details>",
        ]
    )


def file_table(dataset: Dataset) -> str:
    """A row per file of a sequence."""
    lines = [
        ("`left/` `right/`", "PNG, 8 bit, colour: what the cameras filmed; files count from 1"),
        ("`background_left/` `background_right/`", "the same without the person"),
    ]
    for label in dataset.labels:
        if label in LABELS:
            folders = " ".join(f"`{folder}/`" for folder in LABELS[label])
            lines.append((folders, _KINDS[label]))
    lines += [
        (f"`{TRUTH}`", "a row a frame and target"),
        (f"`{OBJECTS}`", "a row a frame and object"),
        (f"`{SKELETON}`", "a row a frame and skeleton: 21 joints a hand, the upper body"),
        (f"`{EVENTS}`", "merges, splits, occlusions, contacts as intervals of frames"),
        (f"`{RIG}`", "cameras to the last bit, frame rate, names of the instance ids"),
        (f"`{CALIBRATION}/`", "intrinsics.yml, extrinsics.yml as OpenCV reads them"),
        (f"`{RECIPE}`", "scenario, seed and all values: the sequence can be made again from it"),
        ("`SHA256SUMS`", "checksums, for `sha256sum -c`"),
    ]
    table = [f"| {files} | {content} |" for files, content in lines]
    table_text = "\n".join(["In each `seq_NNNNNN/`:", "", "| what | how |", "|---|---|", *table])
    beside = [text for name, text in _BESIDE.items() if (dataset.folder / name).is_dir()]
    return "\n\n".join([table_text, f"Beside them: {'; '.join(beside)}."]) if beside else table_text


def escaped(text: str) -> str:
    """Escape a name for one line of Markdown, at most 120 characters of it."""
    line = " ".join(text.split())[:120]
    return "".join(f"\\{c}" if c in "\\`*[]|<>#!" else c for c in line)
