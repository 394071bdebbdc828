"""The skeleton of a BVH file and its motion, and how they are read."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError

MAX_JOINTS = 1000

MAX_FRAMES = 500_000
MIN_FRAME_S = 0.001  # faster than any motion capture

_CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")


@dataclass(eq=False)
class Node:
    """A joint: name, parent's index (-1 = root), offset (3,) from it, its channels."""

    name: str
    parent: int
    offset: Floats
    channels: tuple[str, ...] = ()
    ends: list[Floats] = field(default_factory=list)  # offsets of its End Sites


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints, parents before children, and their motion.

    values (n, c): all channels of all joints in order, file's unit and degrees; frame_s: its step.
    """

    nodes: tuple[Node, ...]
    values: Floats
    frame_s: float

    def above(self, joints: Iterable[int]) -> tuple[Skeleton, dict[int, int]]:
        """The skeleton of these joints and all above them, and their indices in it, by the old."""
        kept: set[int] = {0}
        for joint in joints:
            while joint >= 0 and joint not in kept:
                kept.add(joint)
                joint = self.nodes[joint].parent
        index = {old: new for new, old in enumerate(sorted(kept))}
        nodes = tuple(
            replace(self.nodes[k], parent=index.get(self.nodes[k].parent, -1)) for k in index
        )
        counts = np.array([len(node.channels) for node in self.nodes])
        columns = np.isin(np.repeat(np.arange(len(counts)), counts), list(index))
        return Skeleton(nodes, self.values[:, columns], self.frame_s), index

    def places(self) -> tuple[Floats, Floats]:
        """Positions (n, k, 3) of all joints, and rotations (n, k, 3, 3) own -> world.

        Channels apply from left to right: their matrices are multiplied in the order of the file.
        """
        n, k = len(self.values), len(self.nodes)
        positions, rotations = np.empty((n, k, 3)), np.empty((n, k, 3, 3))
        column = 0
        for index, node in enumerate(self.nodes):
            moved = np.broadcast_to(node.offset, (n, 3)).copy()
            turn = np.broadcast_to(np.eye(3), (n, 3, 3))
            for channel in node.channels:
                axis, value = "XYZ".index(channel[0]), self.values[:, column]
                if channel.endswith("position"):
                    # A position replaces the offset, as all common readers take it.
                    moved[:, axis] = value
                else:
                    turn = turn @ _about(axis, np.radians(value))
                column += 1
            if node.parent < 0:
                positions[:, index], rotations[:, index] = moved, turn
            else:
                above = rotations[:, node.parent]
                positions[:, index] = positions[:, node.parent] + (above @ moved[..., None])[..., 0]
                rotations[:, index] = above @ turn
        return positions, rotations


def _about(axis: int, angles: Floats) -> Floats:
    """Rotations (n, 3, 3) about x, y or z."""
    c, s = np.cos(angles), np.sin(angles)
    turn = np.zeros((len(angles), 3, 3))
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turn[:, axis, axis] = 1.0
    turn[:, a, a], turn[:, a, b], turn[:, b, a], turn[:, b, b] = c, -s, s, c
    return turn


class _Tokens:
    """Tokens of a text with their line numbers; faults name the line."""

    def __init__(self, text: str, path: str) -> None:
        self._tokens: Iterator[tuple[int, str]] = (
            (number, word)
            for number, line in enumerate(text.splitlines(), 1)
            for word in line.split()
        )
        self._path, self._line = path, 1

    def next(self) -> str:
        try:
            self._line, word = next(self._tokens)
        except StopIteration:
            raise self.fault("ends here, too early") from None
        return word

    def expect(self, *choices: str) -> str:
        word = self.next()
        for choice in choices:
            if word.lower() == choice.lower():
                return choice
        raise self.fault(f"must be {' or '.join(choices)}, got {word[:40]!r}")

    def number(self) -> float:
        word = self.next()
        try:
            value = float(word)
        except ValueError:
            raise self.fault(f"must be a number, got {word[:40]!r}") from None
        if not math.isfinite(value):
            raise self.fault(f"must be finite, got {word[:40]!r}")
        return value

    def whole(self, most: int) -> int:
        word = self.next()
        if not word.isascii() or not word.isdigit() or len(word) > 9 or int(word) > most:
            raise self.fault(f"must be a whole number up to {most}, got {word[:40]!r}")
        return int(word)

    def fault(self, message: str) -> BenchError:
        return BenchError(f"{self._path}:{self._line}: {message}")


def read_bvh(text: str, path: str) -> Skeleton:
    """The skeleton and motion of a BVH text; `path` names it in faults. Raises BenchError."""
    head, mark, tail = _halves(text)
    tokens = _Tokens(head, path)
    tokens.expect("HIERARCHY")
    nodes = _hierarchy(tokens)
    if not mark:
        raise BenchError(f"{path}: has no line MOTION")
    line = head.count("\n") + 1
    return _motion(tail, path, line, nodes)


def _halves(text: str) -> tuple[str, str, str]:
    match = re.search(r"^[ \t]*MOTION[ \t\r]*$", text, re.MULTILINE | re.IGNORECASE)
    if match is None:
        return text, "", ""
    return text[: match.start()], "MOTION", text[match.end() :]


def _hierarchy(tokens: _Tokens) -> tuple[Node, ...]:
    tokens.expect("ROOT")
    nodes: list[Node] = []
    _begin(tokens, nodes, -1)
    here = 0  # the joint whose block is open
    while here >= 0:
        word = tokens.expect("JOINT", "End", "CHANNELS", "}")
        if word == "}":
            here = nodes[here].parent
        elif word == "CHANNELS":
            count = tokens.whole(6)
            channels = tuple(tokens.expect(*_CHANNELS) for _ in range(count))
            if len(set(channels)) < count or nodes[here].channels:
                raise tokens.fault(f"{nodes[here].name}: a channel is given twice")
            nodes[here].channels = channels
        elif word == "End":
            tokens.expect("Site")
            tokens.expect("{")
            tokens.expect("OFFSET")
            nodes[here].ends.append(np.array([tokens.number() for _ in range(3)]))
            tokens.expect("}")
        else:
            if len(nodes) == MAX_JOINTS:
                raise tokens.fault(f"has more than {MAX_JOINTS} joints")
            _begin(tokens, nodes, here)
            here = len(nodes) - 1
    return tuple(nodes)


def _begin(tokens: _Tokens, nodes: list[Node], parent: int) -> None:
    """NAME { OFFSET x y z; a name may have spaces."""
    name = [tokens.next()]
    while (word := tokens.next()) != "{":
        name.append(word)
        if len(name) > 8 or word in ("}", "OFFSET"):
            raise tokens.fault("a joint's name must be followed by {")
    tokens.expect("OFFSET")
    offset = np.array([tokens.number() for _ in range(3)])
    nodes.append(Node(" ".join(name), parent, offset))


def _motion(text: str, path: str, line: int, nodes: tuple[Node, ...]) -> Skeleton:
    lines = [(line + k, part.split()) for k, part in enumerate(text.split("\n"))]
    lines = [(number, cells) for number, cells in lines if cells]
    head = [" ".join(cells) for _, cells in lines[:2]]
    frames = re.fullmatch(r"Frames ?: ?(\d{1,9})", head[0], re.IGNORECASE) if head else None
    step = re.fullmatch(r"Frame Time ?: ?(\S+)", head[1], re.IGNORECASE) if head[1:] else None
    if frames is None or step is None:
        number = lines[0][0] if frames is None and lines else line + 1
        raise BenchError(f"{path}:{number}: MOTION needs the lines Frames: N and Frame Time: S")
    count = int(frames[1])
    try:
        frame_s = float(step[1])
        if not MIN_FRAME_S <= frame_s <= 10.0:
            raise ValueError
    except ValueError:
        raise BenchError(
            f"{path}:{lines[1][0]}: Frame Time must be from {MIN_FRAME_S:g} to 10 s, "
            f"got {step[1][:40]}"
        ) from None
    if count > MAX_FRAMES:
        raise BenchError(f"{path}:{lines[0][0]}: has more than {MAX_FRAMES} frames")
    rows = lines[2:]
    if len(rows) != count:
        raise BenchError(
            f"{path}:{lines[0][0]}: Frames: {count}, but {len(rows)} lines of motion follow"
        )
    channels = sum(len(node.channels) for node in nodes)
    values = np.empty((count, channels))
    for row, (number, cells) in enumerate(rows):
        if len(cells) != channels:
            raise BenchError(
                f"{path}:{number}: has {len(cells)} numbers, the skeleton {channels} channels"
            )
        try:
            values[row] = cells
        except ValueError as fault:
            raise BenchError(f"{path}:{number}: must be numbers: {fault}") from None
        if not np.isfinite(values[row]).all():
            raise BenchError(f"{path}:{number}: holds a number that is not finite")
    return Skeleton(nodes, values, frame_s)
