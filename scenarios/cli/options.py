"""Arguments and options that several verbs share, each declared once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pjpdaf.errors import BenchError
from pjpdaf.layouts import LAYOUTS, Layout

Targets = Annotated[
    list[str] | None,
    typer.Argument(metavar="SCENARIO|SUITE", help="Names, or YAML files."),
]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a saved run.")]
DatasetFolder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a data set.")]

PresetName = Annotated[
    str, typer.Option(help="Detector and tracker of this preset: default, thesis, thesis-literal.")
]
PlugInName = Annotated[str | None, typer.Option(help="Preset, entry point or module:factory.")]
ScenarioSettings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a scenario parameter. Repeatable."),
]
Jobs = Annotated[int | None, typer.Option(help="Worker processes [all cores].")]
Cluster = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS|local:N",
        help="Play on a Dask cluster: its scheduler's tcp://HOST:PORT, or N workers started here.",
    ),
]
Detections = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE|DIR",
        help="2-D detections of another detector, CSV or Parquet, in place of --detector.",
    ),
]
ByTarget = Annotated[
    bool, typer.Option("--by-target", help="Print a row for each target of each scenario.")
]
Lag = Annotated[
    int,
    typer.Option(
        metavar="N",
        help="Fixed-lag smoothing: estimates of a frame come N frames later and know these.",
    ),
]
RunOut = Annotated[Path | None, typer.Option(help="Folder of the saved run [runs/NAME-DATE-TIME].")]
ExportFormats = Annotated[
    str | None,
    typer.Option(
        metavar="A,B",
        help="Of coco, mot, webdataset, parquet, yolo-pose, yolo-seg, middlebury, hdf5; or "
        "none [coco,mot].",
    ),
]

LeftView = Annotated[
    Path, typer.Option(metavar="DIR|VIDEO", help="Left view: folder, pattern or video.")
]
RightView = Annotated[Path | None, typer.Option(metavar="DIR|VIDEO", help="Right view, likewise.")]
StereoLayout = Annotated[
    str,
    typer.Option(
        "--stereo",
        help="separate; or both views in each picture of --left: side-by-side, top-bottom.",
    ),
]
Shortest = Annotated[
    bool, typer.Option("--shortest", help="Of views of unlike length leave out the rest.")
]
ResultsOut = Annotated[Path, typer.Option(metavar="DIR", help="New folder for all results.")]


def read_layout(text: str) -> Layout:
    """Read --stereo. Raises BenchError."""
    for layout in LAYOUTS:
        if text == layout:
            return layout
    from scenarios.spec.suggestion import suggestion

    raise BenchError(f"--stereo {text[:40]}: no such layout{suggestion(text, LAYOUTS)}")


def refuse_both_detectors(detections: Path | None, detector: str | None) -> None:
    """Raise BenchError where both --detections and --detector are given."""
    if detections is not None and detector is not None:
        raise BenchError("--detections takes the place of --detector: give one of them")
