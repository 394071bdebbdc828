"""Sections of a data set's card that are prose and code."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from reports.dataset.card_tables import escaped
from reports.summary.text import count
from sim.dataset.croissant import CITATION, NAME, versions_of
from sim.dataset.files.conventions import conventions
from sim.dataset.raytruth import RayFigures, lines_of
from sim.dataset.reader import Dataset
from sim.dataset.statistics import Statistics


def overview(dataset: Dataset, statistics: Statistics) -> str:
    """Content and purpose of the data set."""
    cameras = dataset.sequences[0].rig.cameras if dataset.sequences else ()
    sizes = {f"{camera.width_px} x {camera.height_px}" for camera in cameras}
    labels = ", ".join(dataset.labels) or "none beside truth.parquet"
    return (
        f"{count(statistics.sequences, 'rendered stereo sequence')} of a seated person, "
        f"{statistics.frames} stereo frames ({', '.join(sorted(sizes))} pixels a view, "
        f"{statistics.seconds:.0f} s), with exact labels of the head and both hands in every frame "
        "and view. For tracking, detection, segmentation, keypoints, depth and stereo; above all "
        "for what happens while hands cross, touch and hide each other or the face.\n\n"
        f"Labels as pictures: {labels}. In tables: 3-D position, orientation and velocity; box, "
        "visible fraction, truncation and occluders in each view; keypoints; events.\n\n"
        "In the picture below: what both cameras filmed; depth (red near, blue far); instance ids; "
        "amodal masks, striped where the target is hidden."
    )


def loading(dataset: Dataset) -> str:
    """Two pieces of code that load the data set, with this package and without."""
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
    without = [
        "import cv2",
        "import pandas as pd",
        "",
        f'rows = pd.read_parquet("{first}/truth.parquet")',
        'row = rows[rows.target == "right_hand"].iloc[0]',
        'file = f"{row.frame_index + 1:06d}.png"',
        f'left = cv2.imread(f"{first}/left/{{file}}")',
    ]
    if "depth" in dataset.labels:
        without.append(
            f'depth_m = cv2.imread(f"{first}/depth_left/{{file}}", cv2.IMREAD_UNCHANGED) * 1e-4'
        )
    if "seg" in dataset.labels:
        without.append(
            f'hand = cv2.imread(f"{first}/seg_left/{{file}}", cv2.IMREAD_UNCHANGED) == 2'
        )
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
            *without,
            "```",
        ]
    )


def conventions_list() -> str:
    """The conventions, an item each."""
    lines = []
    for key, value in conventions().items():
        text = value if isinstance(value, str) else f"`{json.dumps(value, ensure_ascii=False)}`"
        name = key.replace("_", " ")
        lines.append(f"- **{name}**: {text}")
    return "\n".join(lines)


def exactness(figures: RayFigures | None) -> str:
    """How exact depth, ids and masks are, as measured by rays."""
    origin = (
        "Depth, ids and masks come from one pass without antialiasing, at the pixels' centres; "
        "the meshes are those of the pictures."
    )
    if figures is None or not figures.pixels:
        return f"{origin} Not measured for this copy: `pjpdaf-bench dataset verify` does it."
    lines = [f"- {line}" for line in lines_of(figures)]
    return "\n".join(
        [
            f"{origin} Against {figures.rays} independent rays, for {figures.pixels} pixels:",
            "",
            *lines,
        ]
    )


def making(dataset: Dataset, command: Sequence[str]) -> str:
    """Versions, renderer and command behind the data set."""
    made_with = dataset.manifest.get("made_with")
    renderer = made_with.get("renderer") if isinstance(made_with, Mapping) else None
    versions = [f"{escaped(str(n))} {escaped(str(v))}" for n, v in versions_of(dataset).items()]
    lines = [
        "Rendered by pjpdaf-bench: a posed and scripted person in MuJoCo, filmed by two calibrated "
        "cameras with a model of the sensor. The same recipe gives the same bytes with the same "
        "versions and renderer.",
    ]
    if versions:
        lines.append(f"Versions: {', '.join(sorted(versions))}.")
    if renderer:
        lines.append(f"Renderer: {escaped(str(renderer))}.")
    if command:
        lines.append(f"```\npjpdaf-bench {shlex.join(without_paths(command))}\n```")
    return "\n\n".join(lines)


def without_paths(command: Sequence[str]) -> list[str]:
    """Strip a command of all that is of a machine: paths and the number of processes."""
    kept: list[str] = []
    skip = False
    for word in command:
        option, _, value = word.partition("=")
        if skip or option in ("--jobs", "-j"):
            skip = not skip and not value
            continue
        if value and "/" in value and option.startswith("-"):
            word = f"{option}={Path(value).name}"
        elif "/" in word and not value:
            word = Path(word).name
        kept.append(word)
    return kept


def limits() -> str:
    """What the simulation leaves out."""
    return (
        "It is a simulation. One seated person, whose skin, hair and clothes are painted meshes: "
        "no face that moves, no cloth that folds, no skin that deforms where it touches. Light is "
        "that of a simple renderer, without reflections between things. Motions follow scripts, or "
        "recordings, within what a body can do, and grasped things follow the hand without forces. "
        "Fingers bend, but keypoints are of the drawn hand, not of an anatomy. Noise, blur, lens "
        "and lost pictures are models. What is learnt here has to be proved on real pictures; "
        "shares of events say nothing of how often they happen in life."
    )


def licence(dataset: Dataset) -> str:
    """Licence and citation."""
    version = str(versions_of(dataset).get("pjpdaf-bench", "of an unknown version"))
    return (
        "Pictures and labels: [CC BY 4.0](https://creativecommons.org/licenses/by/4.0/). "
        "No real person is shown.\n\n"
        f"> {CITATION.format(name=NAME, version=escaped(version))}"
    )
