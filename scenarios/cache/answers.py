"""A detector's answers to the frames of an episode, as arrays and back, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.detector.face import HeadPlace
from pjpdaf.detector.guidance import Guidance, Scope
from pjpdaf.interfaces import Detections
from pjpdaf.looks import BlobLooks, Silhouette
from scenarios.cache.array_file import Arrays

NO_BOX = (-1, -1, -1, -1)


@dataclass(frozen=True, eq=False)
class Answer:
    """The detections of a frame, per view, and the guidance for which they are the same.

    detect_s: the time that the detector took [s].
    """

    detections: tuple[Detections, ...]
    scopes: tuple[Scope, ...]
    detect_s: float

    def holds(self, guidance: Sequence[Guidance]) -> bool:
        """Whether the detector's answer to this guidance is the same."""
        return all(scope.holds(one) for scope, one in zip(self.scopes, guidance, strict=True))


Answers = Mapping[int, Sequence[Answer]]  # by the number of the frame


def answers_to_arrays(answers: Answers) -> dict[str, NDArray[Any]]:
    """The answers as flat arrays. Raises ValueError for detections with masks or evidence."""
    kept = [(frame, answer) for frame, of_frame in sorted(answers.items()) for answer in of_frame]
    seen = [view for _, answer in kept for view in answer.detections]
    if any(view.mask is not None or view.evidence is not None for view in seen):
        raise ValueError("detections with masks or evidence are not kept")
    scopes = [scope for _, answer in kept for scope in answer.scopes]
    looks = [view.looks for view in seen]
    there = [look for look in looks if look is not None]
    pixels = [points for look in there for points in look.pixels]
    shapes = [None if look is None else look.silhouette for look in looks]
    classes = [shape.classes for shape in shapes if shape is not None]
    return {
        "frames": np.array([frame for frame, _ in kept], np.int32),
        "detect_s": np.array([answer.detect_s for _, answer in kept], np.float64),
        "limits_px": np.array([scope[:2] for scope in scopes], np.float64),
        "placed": np.array([scope.place is not None for scope in scopes], np.uint8),
        "tops_px": np.array([_top(scope) for scope in scopes], np.float64),
        "boxes": np.array([_box(scope) for scope in scopes], np.int32),
        "missing": np.array([view.missing for view in seen], np.uint8),
        "counts": np.array([len(view) for view in seen], np.int32),
        "centres": np.concatenate([view.centres_px for view in seen]),
        "covariances": np.concatenate([view.covariances_px2 for view in seen]),
        "ellipses": np.concatenate([view.ellipses for view in seen]),
        "areas": np.concatenate([view.areas_px for view in seen]),
        "pixel_areas": np.array([_pixel_area(look) for look in looks], np.float64),
        "palms": np.concatenate([np.zeros((0, 2)), *(look.palms for look in there)]),
        "fingers": np.concatenate([np.zeros((0, 2)), *(look.fingers for look in there)]),
        "pixel_counts": np.array([len(points) for points in pixels], np.int32),
        "pixels": np.concatenate([np.zeros((0, 2)), *pixels]),
        "silhouettes": np.array([_silhouette(shape) for shape in shapes], np.int32),
        "classes": np.concatenate([np.zeros(0, np.uint8), *(c.ravel() for c in classes)]),
    }


def answers_from_arrays(arrays: Arrays) -> dict[int, list[Answer]]:
    """The inverse of `answers_to_arrays`. Raises ValueError where arrays do not fit together."""
    try:
        return _answers(_Reader(arrays))
    except (KeyError, IndexError, TypeError) as fault:
        raise ValueError(f"is no record of detections: {fault}") from fault


def _top(scope: Scope) -> tuple[float, float]:
    at = None if scope.place is None else scope.place.top_px
    return (np.nan, np.nan) if at is None else at


def _box(scope: Scope) -> tuple[int, int, int, int]:
    box = None if scope.place is None else scope.place.box
    return NO_BOX if box is None else box


def _pixel_area(looks: BlobLooks | None) -> float:
    return np.nan if looks is None else looks.pixel_area_px


def _silhouette(shape: Silhouette | None) -> tuple[int, int, int]:
    """Height, width, step; 0 for none."""
    if shape is None:
        return 0, 0, 0
    height, width = shape.classes.shape
    return height, width, shape.step_px


class _Reader:
    """Takes rows from the arrays, in order."""

    def __init__(self, arrays: Arrays) -> None:
        self._arrays, self._at = arrays, dict.fromkeys(arrays, 0)

    def frames(self) -> list[int]:
        return [int(frame) for frame in self._arrays["frames"]]

    def views(self, answers: int) -> int:
        """Number of views of each of the answers."""
        views, left = divmod(len(self._arrays["missing"]), max(answers, 1))
        if left:
            raise ValueError("answers of another number of views")
        return views

    def one(self, name: str) -> Any:
        """The next row."""
        self._at[name] += 1
        return self._arrays[name][self._at[name] - 1]

    def rows(self, name: str, count: int) -> NDArray[Any]:
        """The next rows, in memory of their own, as those of a detector are."""
        start = self._at[name]
        self._at[name] = start + count
        array = self._arrays[name][start : start + count].copy()
        if count < 0 or len(array) != count:
            raise ValueError(f"{name}: too few")
        return array


def _answers(reader: _Reader) -> dict[int, list[Answer]]:
    answers: dict[int, list[Answer]] = {}
    frames = reader.frames()
    views = reader.views(len(frames))
    for frame in frames:
        scopes, seen = zip(*((_scope(reader), _view(reader)) for _ in range(views)), strict=True)
        answers.setdefault(frame, []).append(Answer(seen, scopes, float(reader.one("detect_s"))))
    return answers


def _scope(reader: _Reader) -> Scope:
    above_px, upto_px = map(float, reader.one("limits_px"))
    x, y = map(float, reader.one("tops_px"))
    top, right, bottom, left = map(int, reader.one("boxes"))
    if not reader.one("placed"):
        return Scope(above_px, upto_px)
    box = (top, right, bottom, left)
    place = HeadPlace(None if np.isnan(x) else (x, y), None if box == NO_BOX else box)
    return Scope(above_px, upto_px, place)


def _view(reader: _Reader) -> Detections:
    count = int(reader.one("counts"))
    return Detections(
        reader.rows("centres", count),
        reader.rows("covariances", count),
        reader.rows("ellipses", count),
        reader.rows("areas", count),
        missing=bool(reader.one("missing")),
        looks=_looks(reader, count),
    )


def _looks(reader: _Reader, count: int) -> BlobLooks | None:
    pixel_area_px = float(reader.one("pixel_areas"))
    height, width, step_px = map(int, reader.one("silhouettes"))
    if np.isnan(pixel_area_px):
        return None
    shape = None
    if step_px:
        shape = Silhouette(reader.rows("classes", height * width).reshape(height, width), step_px)
    pixels = tuple(reader.rows("pixels", int(reader.one("pixel_counts"))) for _ in range(count))
    palms, fingers = reader.rows("palms", count), reader.rows("fingers", count)
    return BlobLooks(pixels, pixel_area_px, palms, fingers, shape)
