"""README.md of a data set: the card that the Hugging Face Hub reads, with its pictures."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import cv2
import numpy as np
from ruamel.yaml import YAML

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.dataset import colours as look
from reports.dataset.svg_bars import histogram_svg, words_of
from sim.dataset.croissant import CITATION, NAME, versions_of
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import CALIBRATION, CARD, EVENTS, LABELS, OBJECTS, RECIPE, RIG, TRUTH
from sim.dataset.raytruth import RayFigures, lines_of
from sim.dataset.reader import Dataset
from sim.dataset.statistics import Statistics
from sim.dataset.stored_sequence import StoredSequence
from sim.files import disk_faults, written_whole_file
from sim.scene.world import CAMERAS

PICTURES, SAMPLE = "pictures", "sample.jpg"
SAMPLE_ROWS, TILE_PX, GAP_PX, WORDS_PX, QUALITY = 3, 248, 6, 26, 88
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
    "float": "NPZ: the same numbers as float32, not rounded",
}

# Folders of the whole data set, where they were asked for.
_BESIDE = {
    "annotations": "`annotations/`, masks, boxes and keypoints as COCO has them",
    "mot": "`mot/`, tracks as MOTChallenge has them",
}


def write_card(
    dataset: Dataset,
    statistics: Statistics,
    ray_figures: RayFigures | None = None,
    command: Sequence[str] = (),
) -> str:
    """Write README.md and its pictures into the data set's folder; the text.

    ray_figures: what independent rays found (`sim.dataset.raytruth`), None where none were sent.
    command: the words that made it; paths are left out. Raises BenchError of the disk and of
    damaged files.
    """
    folder = dataset.folder / PICTURES
    with disk_faults(folder, "the card"):
        folder.mkdir(exist_ok=True)
    _write(folder / SAMPLE, sample_jpeg(dataset))
    for name, histogram in statistics.histograms.items():
        _write(folder / f"{name}.svg", histogram_svg(histogram).encode())
    text = card_text(dataset, statistics, ray_figures, command)
    _write(dataset.folder / CARD, text.encode())
    return text


def card_text(
    dataset: Dataset,
    statistics: Statistics,
    ray_figures: RayFigures | None = None,
    command: Sequence[str] = (),
) -> str:
    """The text of README.md; the same data set, the same text."""
    parts = [
        f"---\n{_front_matter(statistics)}---",
        f"# {NAME}",
        _what(dataset, statistics),
        f"![Left view, right view and labels of a few frames]({PICTURES}/{SAMPLE})",
        "## Sequences",
        _sequences(dataset, statistics),
        "## Labels in numbers",
        _numbers(statistics),
        "## Files",
        _files(dataset),
        "## Loading",
        _loading(dataset),
        "## Conventions",
        _conventions(),
        "## Exactness",
        _exactness(ray_figures),
        "## How it was made",
        _making(dataset, command),
        "## Limits",
        _limits(),
        "## Licence and citation",
        _licence(dataset),
    ]
    return "\n\n".join(parts) + "\n"


def sample_jpeg(dataset: Dataset) -> bytes:
    """A few frames, a row each: both views and the labels of the left one.

    Of sequences spread evenly over the data set, of each the frame in which most is hidden.
    """
    if not dataset.sequences:
        raise BenchError(f"{dataset.folder}: has no finished sequence; there is nothing to show.")
    chosen = np.linspace(0, len(dataset.sequences) - 1, SAMPLE_ROWS).round().astype(int)
    sequences = [dataset.sequences[i] for i in sorted(set(chosen.tolist()))]
    rows = [_sample_row(sequence) for sequence in sequences]
    # Rigs may differ in their pictures' shape.
    height = max(tile.shape[0] for row in rows for tile in row.values())
    names = list(rows[0])
    width = GAP_PX + len(names) * (TILE_PX + GAP_PX)
    sheet = np.full((WORDS_PX + len(rows) * (height + GAP_PX), width, 3), look.EMPTY, np.uint8)
    for column, name in enumerate(names):
        x = GAP_PX + column * (TILE_PX + GAP_PX)
        words = name.replace("_", " ")
        cv2.putText(
            sheet, words, (x, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (235,) * 3, 1, cv2.LINE_AA
        )
        for r, row in enumerate(rows):
            y = WORDS_PX + r * (height + GAP_PX)
            tile = row[name]
            sheet[y : y + tile.shape[0], x : x + TILE_PX] = tile
    settings = [cv2.IMWRITE_JPEG_QUALITY, QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
    done, jpeg = cv2.imencode(".jpg", sheet, settings)
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(jpeg)


def _sample_row(sequence: StoredSequence) -> dict[str, look.Image]:
    index = _telling_frame(sequence)
    frame = sequence.frame(index)
    camera = sequence.rig.left
    grey = np.full((camera.height_px, camera.width_px, 3), 60, np.uint8)
    pictures = [grey if picture is None else picture for picture in frame.pictures]
    tiles = {name: look.small(p, TILE_PX) for name, p in zip(CAMERAS, pictures, strict=True)}
    seg = sequence.seg(0, index) if sequence.has("seg_left") else None
    if sequence.has("depth_left"):
        tiles["depth"] = look.small(look.depth_picture(sequence.depth_m(0, index)), TILE_PX)
    if seg is not None:
        tiles["seg"] = look.small(look.seg_picture(seg), TILE_PX, exact=True)
    if sequence.has("amodal_left"):
        amodal = look.amodal_picture(pictures[0], sequence.amodal(0, index), seg)
        tiles["amodal"] = look.small(amodal, TILE_PX)
    return tiles


def _telling_frame(sequence: StoredSequence) -> int:
    """Where most of the targets in the picture is hidden, of frames with both pictures."""
    rows, T = sequence.truth, len(TARGETS)
    shown = [rows[f"visible_fraction_{view}"].to_numpy(np.float64) for view in CAMERAS]
    there = [rows[f"amodal_{view}_px"].to_numpy(np.float64) > 0 for view in CAMERAS]
    came = [rows[f"arrived_{view}"].to_numpy(bool) for view in CAMERAS]
    hidden = sum(np.where(t, 1 - s, 0.0) for t, s in zip(there, shown, strict=True))
    cost = np.asarray(hidden).reshape(-1, T).sum(axis=1)
    whole = np.logical_and.reduce([*came, *there]).reshape(-1, T).all(axis=1)
    return int(np.where(whole, cost, -1.0).argmax())


def _front_matter(statistics: Statistics) -> str:
    rows = statistics.frames * len(TARGETS)
    size = next((name for least, name in _SIZES if rows < least), "n>10M")
    configs: list[dict[str, object]] = [
        {"config_name": "truth", "data_files": f"seq_*/{TRUTH}", "default": True}
    ]
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


def _what(dataset: Dataset, statistics: Statistics) -> str:
    cameras = dataset.sequences[0].rig.cameras if dataset.sequences else ()
    sizes = {f"{camera.width_px} x {camera.height_px}" for camera in cameras}
    labels = ", ".join(dataset.labels) or "none beside truth.parquet"
    return (
        f"{_many(statistics.sequences, 'rendered stereo sequence')} of a seated person, "
        f"{statistics.frames} stereo frames ({', '.join(sorted(sizes))} pixels a view, "
        f"{statistics.seconds:.0f} s), with exact labels of the head and both hands in every frame "
        "and view. For tracking, detection, segmentation, keypoints, depth and stereo; above all "
        "for what happens while hands cross, touch and hide each other or the face.\n\n"
        f"Labels as pictures: {labels}. In tables: 3-D position, orientation and velocity; box, "
        "visible fraction, truncation and occluders in each view; keypoints; events.\n\n"
        "In the picture below: what both cameras filmed; depth (red near, blue far); instance ids; "
        "amodal masks, striped where the target is hidden."
    )


def _sequences(dataset: Dataset, statistics: Statistics) -> str:
    if len(dataset.sequences) > LONG_TABLE:
        lines = [
            f"| {_plain(name)} | {sequences} | {frames} |"
            for name, (sequences, frames) in statistics.scenarios.items()
        ]
        head = "| scenario | sequences | frames |\n|---|--:|--:|"
        return "\n".join([head, *lines])
    lines = []
    for one in dataset.sequences:
        entry = one.entry
        words = [str(entry.get(key, "")) for key in ("label", "scenario", "rung", "seed")]
        lines.append(
            f"| {one.name} | {' | '.join(map(_plain, words))} | {one.frame_count} | {one.fps:g} |"
        )
    head = "| folder | label | scenario | rung | seed | frames | frames/s |"
    return "\n".join([head, "|---|---|---|---|--:|--:|--:|", *lines])


def _numbers(statistics: Statistics) -> str:
    pictures = [
        f'<img src="{PICTURES}/{name}.svg" width="460" '
        f'alt="{escape(f"{one.bins.title}. {words_of(one)}", quote=True)}">'
        for name, one in statistics.histograms.items()
    ]
    frames = max(statistics.frames, 1)
    merged = [
        f"| {_plain(pair.replace('_', ' '))} | {count} | {100 * count / frames:.1f} % |"
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


def _files(dataset: Dataset) -> str:
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
        (f"`{EVENTS}`", "merges, splits, occlusions, contacts as intervals of frames"),
        (f"`{RIG}`", "cameras to the last bit, frame rate, names of the instance ids"),
        (f"`{CALIBRATION}/`", "intrinsics.yml, extrinsics.yml as OpenCV reads them"),
        (f"`{RECIPE}`", "scenario, seed and all values: the sequence can be made again from it"),
        ("`SHA256SUMS`", "checksums, for `sha256sum -c`"),
    ]
    table = [f"| {what} | {kind} |" for what, kind in lines]
    text = "\n".join(["In each `seq_NNNNNN/`:", "", "| what | how |", "|---|---|", *table])
    there = [words for name, words in _BESIDE.items() if (dataset.folder / name).is_dir()]
    return "\n\n".join([text, f"Beside them: {'; '.join(there)}."]) if there else text


def _loading(dataset: Dataset) -> str:
    first = dataset.sequences[0].name if dataset.sequences else "seq_000000"
    own = [
        "import sim.dataset",
        "",
        'dataset = sim.dataset.open(".")  # this folder',
        "for sequence in dataset.sequences:",
        "    for frame, truth in sequence.frames():",
        "        left, right = frame.pictures  # BGR; None where a picture was lost",
        "        head_m, right_hand_m, left_hand_m = truth.centres_m",
    ]
    plain = [
        "import cv2",
        "import pandas as pd",
        "",
        f'rows = pd.read_parquet("{first}/truth.parquet")',
        'row = rows[rows.target == "right_hand"].iloc[0]',
        'file = f"{row.frame_index + 1:06d}.png"',
        f'left = cv2.imread(f"{first}/left/{{file}}")',
    ]
    if "depth" in dataset.labels:
        plain.append(
            f'depth_m = cv2.imread(f"{first}/depth_left/{{file}}", cv2.IMREAD_UNCHANGED) * 1e-4'
        )
    if "seg" in dataset.labels:
        plain.append(f'hand = cv2.imread(f"{first}/seg_left/{{file}}", cv2.IMREAD_UNCHANGED) == 2')
    return "\n".join(
        [
            "With pjpdaf-bench, the records that a live simulation gives:",
            "",
            "```python",
            *own,
            "```",
            "",
            "Without it:",
            "",
            "```python",
            *plain,
            "```",
        ]
    )


def _conventions() -> str:
    lines = []
    for key, value in conventions().items():
        said = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
        name = key.replace("_", " ")
        lines.append(f"- **{name}**: {f'`{said}`' if not isinstance(value, str) else said}")
    return "\n".join(lines)


def _exactness(figures: RayFigures | None) -> str:
    said = (
        "Depth, ids and masks come from one pass without antialiasing, at the pixels' centres; "
        "the meshes are those of the pictures."
    )
    if figures is None or not figures.pixels:
        return f"{said} Not measured for this copy: `pjpdaf-bench dataset verify` does it."
    lines = [f"- {line}" for line in lines_of(figures)]
    return "\n".join(
        [
            f"{said} Against {figures.rays} independent rays, for {figures.pixels} pixels:",
            "",
            *lines,
        ]
    )


def _making(dataset: Dataset, command: Sequence[str]) -> str:
    made_with = dataset.manifest.get("made_with")
    renderer = made_with.get("renderer") if isinstance(made_with, Mapping) else None
    versions = [f"{_plain(str(n))} {_plain(str(v))}" for n, v in versions_of(dataset).items()]
    lines = [
        "Rendered by pjpdaf-bench: a posed and scripted person in MuJoCo, filmed by two calibrated "
        "cameras with a model of the sensor. The same recipe gives the same bytes with the same "
        "versions and renderer.",
    ]
    if versions:
        lines.append(f"Versions: {', '.join(sorted(versions))}.")
    if renderer:
        lines.append(f"Renderer: {_plain(str(renderer))}.")
    if command:
        lines.append(f"```\npjpdaf-bench {' '.join(without_paths(command))}\n```")
    return "\n\n".join(lines)


def without_paths(words: Sequence[str]) -> list[str]:
    """The words of a command that says nothing of a machine: no paths, no number of processes."""
    said: list[str] = []
    skip = False
    for word in words:
        option, _, value = word.partition("=")
        if skip or option in ("--jobs", "-j"):
            skip = not skip and not value
            continue
        if value and "/" in value and option.startswith("-"):
            word = f"{option}={Path(value).name}"
        elif "/" in word and not value:
            word = Path(word).name
        said.append(word)
    return said


def _limits() -> str:
    return (
        "It is a simulation. One seated person, whose skin, hair and clothes are painted meshes: "
        "no face that moves, no cloth that folds, no skin that deforms where it touches. Light is "
        "that of a simple renderer, without reflections between things. Motions follow scripts, or "
        "recordings, within what a body can do, and grasped things follow the hand without forces. "
        "Fingers bend, but keypoints are of the drawn hand, not of an anatomy. Noise, blur, lens "
        "and lost pictures are models. What is learnt here has to be proved on real pictures; "
        "shares of events say nothing of how often they happen in life."
    )


def _licence(dataset: Dataset) -> str:
    version = str(versions_of(dataset).get("pjpdaf-bench", "of an unknown version"))
    return (
        "Pictures and labels: [CC BY 4.0](https://creativecommons.org/licenses/by/4.0/). "
        "No real person is shown.\n\n"
        f"> {CITATION.format(name=NAME, version=_plain(version))}"
    )


def _plain(words: str) -> str:
    """Words as one line of Markdown that means nothing but itself; cut where it is very long."""
    line = " ".join(words.split())[:120]
    return "".join(f"\\{c}" if c in "\\`*[]|<>#!" else c for c in line)


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _write(path: Path, data: bytes) -> None:
    with written_whole_file(path, "the card", replace=True) as part, disk_faults(path, "the card"):
        part.write_bytes(data)
