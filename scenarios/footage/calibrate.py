"""The verb `calibrate`: stereo calibration from pictures of a board."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.text import Text

from pjpdaf.boards import Board
from pjpdaf.calibrate import calibrate as calibrate_pairs
from pjpdaf.calibration import view_order_doubt
from pjpdaf.calibration_report import CalibrationReport
from pjpdaf.errors import BenchError
from pjpdaf.layouts import Layout
from pjpdaf.sources import PicturePair, open_source, picture_pairs
from pjpdaf.stereo_solver import LENS_FLAGS
from reports.summary.plain_table import plain_table
from scenarios.console.folder import written_whole
from scenarios.console.lines import print_line
from scenarios.console.progress import progress
from scenarios.console.tables import print_table
from sim.steps import counted


@dataclass(frozen=True)
class CalibrateRequest:
    """The options of `calibrate`; None = not given."""

    left: Path
    right: Path | None
    board: str
    square_m: float
    charuco: str | None
    marker_m: float | None
    coefficients: int
    out: Path
    layout: Layout = "separate"
    shortest: bool = False


def calibrate(request: CalibrateRequest) -> None:
    """Calibrate, save, print. Raises BenchError."""
    board = board_of(request)
    if request.coefficients not in LENS_FLAGS:
        choices = ", ".join(map(str, LENS_FLAGS))
        raise BenchError(f"--coefficients must be one of {choices}, got {request.coefficients}")
    console = Console(stderr=True)
    if request.right is not None and request.left.resolve() == request.right.resolve():
        raise BenchError(f"--left and --right are the same: {request.left}")
    with written_whole(request.out) as part:
        pairs = picture_pairs(
            request.left,
            request.right,
            lambda message: print_line(message, console),
            request.shortest,
            request.layout,
        )
        total = max(open_source(path).count for path in (request.left, request.right) if path)
        with progress(console) as meter:
            meter.begin("finding corners", total or None, "pair")

            def until_solved() -> Iterator[PicturePair]:
                yield from counted(pairs)
                meter.begin("calibrating", None)

            report = calibrate_pairs(until_solved(), board, part, request.coefficients)
        names = [file.relative_to(part) for file in report.files]
    _print(report, Console(), request.out, names)


def board_of(request: CalibrateRequest) -> Board:
    """The board that the options describe. Raises BenchError."""
    shape = re.fullmatch(r"([0-9]+)[xX×]([0-9]+)", request.board)
    if shape is None:
        raise BenchError(
            f"--board must be COLUMNSxROWS of inner corners, such as 9x6, got {request.board!r}"
        )
    columns, rows = int(shape[1]), int(shape[2])
    if request.charuco is None:
        if request.marker_m is not None:
            raise BenchError("--marker is of a ChArUco board; give --charuco DICTIONARY too.")
        return Board("chessboard", columns, rows, request.square_m)
    if request.marker_m is None:
        raise BenchError("A ChArUco board needs --marker, the side of a marker in metres.")
    name = request.charuco.upper()
    dictionary = name if name.startswith("DICT_") else f"DICT_{name}"
    return Board("charuco", columns, rows, request.square_m, request.marker_m, dictionary)


def _print(report: CalibrationReport, out: Console, folder: Path, names: list[Path]) -> None:
    table = plain_table()
    table.add_column("left")
    table.add_column("right")
    table.add_column(Text("error left [px]"), justify="right")
    table.add_column(Text("error right [px]"), justify="right")
    table.add_column("")
    for pair in report.pairs:
        errors = [
            f"{value:.3f}" if np.isfinite(value) else "-"
            for value in (pair.error_left_px, pair.error_right_px)
        ]
        remark = "" if pair.used else f"dropped: {pair.reason}"
        table.add_row(Path(pair.left).name, Path(pair.right).name, *errors, remark)
    print_table(table, out)
    rig = report.rig
    lines = [
        f"{report.used} of {len(report.pairs)} pairs used; reprojection RMS: left "
        f"{report.rms_left_px:.3f} px, right {report.rms_right_px:.3f} px, "
        f"stereo {report.rms_stereo_px:.3f} px; epipolar error {report.epipolar_px:.3f} px",
        f"baseline {1000 * report.baseline_m:.2f} mm",
    ]
    for view, camera, sd in zip(
        ("left", "right"), rig.cameras, (report.sd_left, report.sd_right), strict=True
    ):
        values = (camera.K[0, 0], camera.K[1, 1], camera.K[0, 2], camera.K[1, 2])
        numbers = ", ".join(
            f"{name} {value:.2f} ± {s:.2f}"
            for name, value, s in zip(("fx", "fy", "cx", "cy"), values, sd, strict=False)
        )
        lens = ", ".join(f"{c:.4f}" for c in camera.distortion)
        lines.append(f"{view}: {numbers} px; distortion {lens}")
    top = [str(name) for name in names if len(name.parts) == 1]
    lines.append(f"written to {folder}: {', '.join(top)}, corners/ ({len(names) - len(top)})")
    doubt = view_order_doubt(rig)
    lines += [f"warning: {doubt}."] if doubt else []
    for line in lines:
        print_line(line, out)
