"""Anyone's 2-D detections: CSV or Parquet files become the tables of an `ExternalDetector`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.camera import Camera
from pjpdaf.detector.external import DEFAULT_SD_PX, DetectionTable
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from scenarios.tables.cells import read_frame, read_number
from scenarios.tables.rows import Columns
from scenarios.tables.sequences import read_sequences

VIEWS = ("left", "right")
EVIDENCE = tuple(f"evidence_{target}" for target in TARGETS)
COLUMNS = Columns(("frame", "view", "u_px", "v_px"), ("sd_px", "area_px", "score", *EVIDENCE))
OUTSIDE = 0.5  # of a picture's width or height: how far outside it a detection may be


class DetectionsBuilder:
    """Collects the detections of a sequence.

    cameras: of the sequence, for the size of its pictures; frames: their number, None if unknown;
    min_score: rows with a lower score are left out.
    """

    def __init__(
        self, cameras: Sequence[Camera], frames: int | None, min_score: float = 0.0
    ) -> None:
        self._cameras, self._frames, self._min_score = tuple(cameras), frames, min_score
        self._count = 0
        self._views: tuple[list[tuple[float, ...]], ...] = ([], [])
        self._evidence = False

    @property
    def rows(self) -> int:
        """The number of rows added."""
        return self._count

    def add(self, where: str, row: Mapping[str, Any]) -> None:
        """Add a row. where: its place, with which messages begin. Raises BenchError."""
        self._count += 1
        frame = read_frame(where, row["frame"], self._frames)
        view = _view(where, row["view"])
        camera = self._cameras[view]
        u_px = _inside(where, "u_px", row["u_px"], camera.width_px)
        v_px = _inside(where, "v_px", row["v_px"], camera.height_px)
        sd_px = _above_zero(where, "sd_px", row.get("sd_px"))
        area_px = _above_zero(where, "area_px", row.get("area_px"))
        score = read_number(where, "score", row.get("score"))
        if score is not None and not 0.0 <= score <= 1.0:
            raise BenchError(f"{where}: score must be between 0 and 1, got {score:g}")
        evidence = self._evidence_of(where, row)
        if score is None or score >= self._min_score:
            self._views[view].append(
                (
                    frame,
                    u_px,
                    v_px,
                    DEFAULT_SD_PX if sd_px is None else sd_px,
                    np.nan if area_px is None else area_px,
                    *evidence,
                )
            )

    def tables(self) -> tuple[DetectionTable, ...]:
        """The collected detections, a table a view."""
        return tuple(self._table(rows) for rows in self._views)

    def _table(self, rows: list[tuple[float, ...]]) -> DetectionTable:
        cells = np.array(rows, dtype=np.float64).reshape(-1, 5 + len(TARGETS))
        cells = cells[np.argsort(cells[:, 0], kind="stable")]
        return DetectionTable(
            frames=cells[:, 0].astype(np.intp),
            centres_px=cells[:, 1:3],
            sd_px=cells[:, 3],
            areas_px=cells[:, 4],
            evidence=cells[:, 5:] if self._evidence else None,
        )

    def _evidence_of(self, where: str, row: Mapping[str, Any]) -> list[float]:
        cells = [read_number(where, name, row.get(name)) for name in EVIDENCE]
        given = [name for name, cell in zip(EVIDENCE, cells, strict=True) if cell is not None]
        if not given:
            return [0.0] * len(EVIDENCE)
        if len(given) < len(EVIDENCE):
            raise BenchError(
                f"{where}: has {given[0]} but not all of {', '.join(EVIDENCE)}; give all or none"
            )
        self._evidence = True
        return [float(cell) for cell in cells if cell is not None]


def read_detections(
    path: Path,
    cameras: Mapping[str, Sequence[Camera]],
    frame_counts: Mapping[str, int | None],
    min_score: float = 0.0,
    whole: str = "the data set",
) -> dict[str, tuple[DetectionTable, ...]]:
    """Read the detections of each sequence, a table a view.

    cameras, frame_counts: of the sequences, by name; whole: what they are of, for messages. A
    sequence without any row is absent. Raises BenchError naming file and line.
    """

    def builder(_: Path, name: str) -> DetectionsBuilder:
        return DetectionsBuilder(cameras[name], frame_counts[name], min_score)

    builders = read_sequences(path, list(frame_counts), COLUMNS, builder, "detections", whole)
    return {name: one.tables() for name, one in builders.items()}


def read_min_score(settings: Mapping[str, str]) -> float:
    """Read `--set detector.min_score`, all that can be set of external detections.

    Raises BenchError.
    """
    for key in settings:
        if key != "min_score":
            raise BenchError(
                f"--set detector.{key}: detections come from files; only detector.min_score is left"
            )
    where = "--set detector.min_score"
    score = read_number(where, "it", settings.get("min_score", "0"))
    if score is None or not 0.0 <= score <= 1.0:
        raise BenchError(f"{where}: must be between 0 and 1, got {settings['min_score']!r}")
    return score


def _view(where: str, cell: Any) -> int:
    text = str(cell).strip().lower()
    if text in VIEWS:
        return VIEWS.index(text)
    if text in ("0", "1"):
        return int(text)
    raise BenchError(f"{where}: view must be left or right (or 0, 1), got {str(cell)[:40]!r}")


def _inside(where: str, name: str, cell: Any, size_px: int) -> float:
    value = read_number(where, name, cell)
    if value is None:
        raise BenchError(f"{where}: {name} is empty; a detection needs a place")
    if not -OUTSIDE * size_px <= value <= (1.0 + OUTSIDE) * size_px:
        raise BenchError(
            f"{where}: {name} is {value:g}, far outside the picture of {size_px} pixels; pixels of "
            "the picture as filmed are expected"
        )
    return value


def _above_zero(where: str, name: str, cell: Any) -> float | None:
    value = read_number(where, name, cell)
    if value is not None and value <= 0.0:
        raise BenchError(f"{where}: {name} must be above 0, got {value:g}")
    return value
