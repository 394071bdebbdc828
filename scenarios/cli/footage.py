"""The verbs of real footage: track, calibrate."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from pjpdaf.errors import BenchError
from pjpdaf.presets.names import DEFAULT_PRESET
from scenarios.cli.options import (
    Detections,
    Lag,
    LeftView,
    PlugInName,
    PresetName,
    ResultsOut,
    RightView,
    Shortest,
    StereoLayout,
    read_layout,
    refuse_both_detectors,
)


def track(
    left: LeftView,
    calibration: Annotated[
        tuple[Path, Path],
        typer.Option(
            metavar="INTRINSICS EXTRINSICS",
            help="Files as OpenCV's stereo sample writes them; or two camera_info files of ROS, "
            "left and right; or a camera chain of Kalibr, twice.",
        ),
    ],
    out: ResultsOut,
    right: RightView = None,
    stereo: StereoLayout = "separate",
    shortest: Shortest = False,
    background_left: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Person-free pictures, left view.")
    ] = None,
    background_right: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Person-free pictures, right view.")
    ] = None,
    background_first: Annotated[
        int | None,
        typer.Option(metavar="N", help="Instead: the footage's first N frames are person-free."),
    ] = None,
    background_from_footage: Annotated[
        bool,
        typer.Option(
            "--background-from-footage",
            help="Instead: what is seen most of the time, pixel by pixel. For a person who moves.",
        ),
    ] = False,
    no_background: Annotated[
        bool, typer.Option("--no-background", help="Instead: none, skin colour alone.")
    ] = False,
    fps: Annotated[
        float | None, typer.Option(help="Frames a second [the video's own times; 3 for folders].")
    ] = None,
    preset: PresetName = DEFAULT_PRESET,
    detector: PlugInName = None,
    tracker: PlugInName = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Change detector.NAME or tracker.NAME. Repeatable."
        ),
    ] = None,
    skin_sample: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|head",
            help="Learn the skin's colour from a picture cropped to skin, or from the head in the "
            "first frames.",
        ),
    ] = None,
    unit: Annotated[
        str,
        typer.Option(help="Unit of the calibration's T: m, cm, mm, in, or a number of metres."),
    ] = "m",
    detections: Detections = None,
    lag: Lag = 0,
) -> None:
    """Track head and hands in real footage: tracks.csv, tracks.parquet, overlay film, report page.

    Positions are in the left camera's frame (OpenCV: x right, y down, z forward), in metres.
    """
    from scenarios.footage.session import TrackRequest
    from scenarios.footage.track import track as track_footage

    refuse_both_detectors(detections, detector)
    for path in calibration:
        if str(path).startswith("--"):
            raise BenchError(
                f"--calibration takes two files, but its second is the option {path}; a file that "
                "holds both cameras is given twice"
            )
    track_footage(
        TrackRequest(
            left=left,
            right=right,
            calibration=calibration,
            background_left=background_left,
            background_right=background_right,
            background_first=background_first,
            fps=fps,
            preset=preset,
            detector=detector or (preset if detections is None else detections.name),
            tracker=tracker or preset,
            settings=tuple(settings or ()),
            skin_sample=skin_sample,
            unit=unit,
            out=out,
            argv=tuple(sys.argv[1:]),
            layout=read_layout(stereo),
            shortest=shortest,
            no_background=no_background,
            background_from_footage=background_from_footage,
            detections=detections,
            lag=lag,
        )
    )


def calibrate(
    left: LeftView,
    board: Annotated[
        str, typer.Option(metavar="9x6", help="Inner corners of the board, columns x rows.")
    ],
    square: Annotated[float, typer.Option(metavar="M", help="Side of a square [m].")],
    out: ResultsOut,
    right: RightView = None,
    stereo: StereoLayout = "separate",
    shortest: Shortest = False,
    charuco: Annotated[
        str | None,
        typer.Option(metavar="DICT", help="ChArUco board with markers such as DICT_4X4_50."),
    ] = None,
    marker: Annotated[
        float | None, typer.Option(metavar="M", help="Side of a ChArUco marker [m].")
    ] = None,
    coefficients: Annotated[
        int, typer.Option(help="Coefficients of the lens model: 4, 5, 8, 12 or 14.")
    ] = 5,
) -> None:
    """Calibrate two cameras from pictures of a chessboard or ChArUco board.

    Writes intrinsics.yml and extrinsics.yml as OpenCV's stereo sample does, the corners, and
    a rectified pair.
    """
    from scenarios.footage.calibrate import CalibrateRequest
    from scenarios.footage.calibrate import calibrate as calibrate_cameras

    calibrate_cameras(
        CalibrateRequest(
            left,
            right,
            board,
            square,
            charuco,
            marker,
            coefficients,
            out,
            read_layout(stereo),
            shortest,
        )
    )
