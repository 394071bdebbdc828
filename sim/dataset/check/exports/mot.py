"""MOTChallenge's files against the numbers of the sequences."""

from __future__ import annotations

import configparser
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from pjpdaf.arrays import Floats
from sim.dataset.check.exports.numbers import SequenceNumbers
from sim.dataset.check.fault import MISSING, Fault
from sim.dataset.check.files import FileTree
from sim.scene.world import CAMERAS

FOLDER = "mot"
METRES = 1e-6  # to which positions are written
WHOLE = 5  # numbers of a line after frame and id that are whole; the others are rounded


def check_mot(tree: FileTree, numbers: SequenceNumbers) -> Iterator[Fault]:
    """Check the folders of a sequence, one per view."""
    for view in range(len(CAMERAS)):
        yield from _view_faults(tree, view, numbers)


def _view_faults(tree: FileTree, view: int, numbers: SequenceNumbers) -> Iterator[Fault]:
    folder = f"{FOLDER}/{numbers.name}-{CAMERAS[view]}"
    info, boxes = f"{folder}/seqinfo.ini", f"{folder}/gt/gt.txt"
    positions = f"{folder}/gt/gt_3d.txt"
    for file in (info, boxes, positions):
        if file not in tree.plain:
            yield Fault(file, MISSING)
            return
    visible = {
        (index + 1, t + 1): np.array(
            [*(numbers.boxes_px[view, index, t] + (1, 1, 0, 0)), 1, 1, share]
        )
        for (index, t), share in np.ndenumerate(numbers.fractions[view])
        if numbers.arrived[index, view] and numbers.visible_px[view, index, t]
    }
    hidden = np.array([-1.0, -1, -1, -1, 0])
    everywhere = {
        (index + 1, t + 1): np.append(
            visible[index + 1, t + 1][:5] if (index + 1, t + 1) in visible else hidden,
            numbers.centres_m[index, t],
        )
        for index, t in np.ndindex(numbers.centres_m.shape[:2])
    }
    yield from _line_faults(tree.root, boxes, visible)
    yield from _line_faults(tree.root, positions, everywhere)
    yield from _seqinfo_faults(tree.root, info, numbers)


def _line_faults(
    root: Path, file: str, expected: Mapping[tuple[int, int], Floats]
) -> Iterator[Fault]:
    """Compare the lines of a file. expected: by frame and id, the numbers after them."""
    try:
        text = (root / file).read_text(encoding="ascii")
        rows = [[float(cell) for cell in line.split(",")] for line in text.splitlines()]
        lines = {(int(row[0]), int(row[1])): np.array(row[2:]) for row in rows}
    except (OSError, ValueError, IndexError) as error:
        yield Fault(file, f"is not MOTChallenge's ground truth: {error}")
        return
    if len(lines) != len(rows) or set(lines) != set(expected):
        others = sorted(set(lines) ^ set(expected))
        first = f", first frame {others[0][0]}, id {others[0][1]}" if others else ""
        yield Fault(file, f"has {len(rows)} lines, {len(expected)} are wanted{first}")
    wrong = []
    for key in sorted(set(lines) & set(expected)):
        values, right = lines[key], expected[key]
        if values.shape != right.shape or not (
            np.array_equal(values[:WHOLE], right[:WHOLE])
            and np.abs(values[WHOLE:] - right[WHOLE:]).max() <= METRES
        ):
            text = f"{_text(values)}; it should be {_text(right)}"
            wrong.append(f"frame {key[0]}, id {key[1]}: {text}")
    if wrong:
        more = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
        yield Fault(file, f"{wrong[0]} (counted from 1){more}")


def _seqinfo_faults(root: Path, file: str, numbers: SequenceNumbers) -> Iterator[Fault]:
    expected = {
        "seqlength": len(numbers.arrived),
        "framerate": numbers.fps,
        "imwidth": numbers.size_px[0],
        "imheight": numbers.size_px[1],
    }
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string((root / file).read_text(encoding="ascii"))
        stored = {key: float(parser["Sequence"][key]) for key in expected}
    except (OSError, ValueError, KeyError, configparser.Error) as error:
        yield Fault(file, f"is not MOTChallenge's seqinfo: {error!r}")
        return
    for key, value in expected.items():
        if not abs(stored[key] - value) <= 1e-4 * value:
            yield Fault(file, f"{key} is {stored[key]:g}, the sequence has {value:g}")


def _text(values: Floats) -> str:
    return " ".join(f"{value:g}" for value in values.tolist())
