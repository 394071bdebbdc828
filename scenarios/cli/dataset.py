"""The verbs of `dataset`: make, verify, export, show."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Annotated

import typer

from pjpdaf.errors import BenchError
from scenarios.cli.help import SentenceGroup
from scenarios.cli.options import (
    Cluster,
    DatasetFolder,
    ExportFormats,
    Jobs,
    ScenarioSettings,
    Targets,
)

app = typer.Typer(cls=SentenceGroup, help="Labelled stereo data sets.", no_args_is_help=True)


@app.command()
def make(
    targets: Targets = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the data set; one that is begun goes on."),
    ] = None,
    seeds: Annotated[
        int | None, typer.Option(help="Seeds of each scenario [a suite's own, else 10].")
    ] = None,
    first_seed: Annotated[int, typer.Option(help="The first of them.")] = 0,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Of the pictures [640x480].")
    ] = None,
    labels: Annotated[
        str,
        typer.Option(
            metavar="A,B",
            help="Of clean, depth, seg, amodal, disparity, correspondence, semantic, normals, "
            "flow, float; or training (depth, seg, disparity, semantic), all, none.",
        ),
    ] = "depth,seg,amodal,disparity",
    export: ExportFormats = None,
    ladder: Annotated[
        bool,
        typer.Option(
            "--ladder",
            help="Each sequence five times: clean, + noise, + blur, + lens, + skin and light.",
        ),
    ] = False,
    varied: Annotated[
        bool,
        typer.Option(
            "--varied",
            help="Each sequence in a room, body and rig of its own [the suite varied].",
        ),
    ] = False,
    settings: ScenarioSettings = None,
    jobs: Jobs = None,
    cluster: Cluster = None,
    recipe: Annotated[
        Path | None,
        typer.Option(metavar="recipe.json", help="Instead: this one sequence again."),
    ] = None,
    frame: Annotated[
        int | None, typer.Option(help="With --recipe: only this frame, from 0.")
    ] = None,
) -> None:
    """Make a labelled data set; the same command goes on with one that was interrupted.

    The same scenarios, seeds and settings give the same bytes, for any number of workers.
    """
    if out is None:
        raise BenchError("--out is missing: give the folder of the data set")
    if recipe is not None:
        if targets:
            raise BenchError("--recipe makes its own sequence: leave out the scenarios")
        from scenarios.dataset.remake import remake_sequence

        typer.echo(remake_sequence(recipe, out, frame))
        return
    if frame is not None:
        raise BenchError("--frame is for a recipe: give --recipe FILE")
    from scenarios.dataset.make import make_dataset
    from scenarios.dataset.sequence_plan import MakeRequest
    from scenarios.play.recipe import SequenceSettings, parse_labels, parse_size

    chosen = parse_labels(labels)
    make_dataset(
        MakeRequest(
            targets=tuple(targets or ("varied" if varied else "smoke",)),
            out=out,
            seeds=seeds,
            first_seed=first_seed,
            settings=tuple(settings or ()),
            labels=SequenceSettings(chosen, None if size is None else parse_size(size)),
            exports=parse_formats(export, chosen),
            ladder=ladder,
            varied=varied,
            jobs=jobs,
            cluster=cluster,
        )
    )


@app.command()
def export(
    folder: DatasetFolder,
    to: ExportFormats = None,
    jobs: Jobs = None,
) -> None:
    """Write a data set in other formats too, into its own folder; older ones are replaced.

    coco: annotations/, mot: mot/, webdataset: webdataset/ (tar files), parquet: parquet/ (with the
    pictures in it, as Hugging Face's `datasets` reads it), yolo-pose: yolo-pose/ (hands),
    yolo-seg: yolo-seg/ (masks), middlebury: middlebury/ (rectified pairs, disparity as PFM),
    hdf5: hdf5/ (a file a sequence).
    """
    from scenarios.dataset.finish import export_dataset
    from scenarios.execute.local import worker_count
    from sim.dataset.reader import open_dataset

    formats = parse_formats(to, open_dataset(folder).labels)
    for path in export_dataset(folder, formats, worker_count(jobs)):
        typer.echo(path)


@app.command()
def show(
    folder: DatasetFolder,
    out: Annotated[
        Path | None,
        typer.Option(help="New folder for both, or a .png or .html file [DIR-show]."),
    ] = None,
    sequence: Annotated[int | None, typer.Option(min=0, help="Only this sequence.")] = None,
    rerun: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.rrd", help="Instead: a recording for the viewer Rerun (extra viz)."
        ),
    ] = None,
) -> None:
    """A contact sheet and a page that plays all labels of a data set."""
    from scenarios.dataset.show import ShowDatasetRequest, show_dataset

    typer.echo(show_dataset(ShowDatasetRequest(folder, out, sequence, rerun)))


@app.command()
def verify(
    folder: DatasetFolder,
    sums: Annotated[
        bool, typer.Option("--sums/--no-sums", help="Compare every file's SHA-256 too.")
    ] = True,
    rays: Annotated[
        int, typer.Option(help="Frames compared with rays into the rebuilt scenes; 0: none.")
    ] = 4,
    jobs: Jobs = None,
) -> None:
    """Check a data set: every fault is a line with its file; exit code 1 then.

    Checksums, both eyes, masks, boxes, depth, disparity, calibration and exports against each
    other and against the 3-D truth; depth and ids against rays.
    """
    from scenarios.dataset.verify import VerifyRequest, verify_dataset
    from scenarios.execute.local import worker_count

    raise typer.Exit(verify_dataset(VerifyRequest(folder, sums, rays, worker_count(jobs))))


def parse_formats(text: str | None, labels: Collection[str]) -> tuple[str, ...]:
    """Read export formats such as "coco,mot" or "none"; None: coco and mot, if labels allow.

    Raises BenchError for an unknown format, or a format whose label is missing.
    """
    from scenarios.spec.suggestion import suggestion
    from sim.dataset.files.layout import EXPORTS, EXPORTS_NEED

    if text is None:
        return ("coco", "mot") if "seg" in labels else ("mot",)
    named = [word.strip() for word in text.split(",") if word.strip()]
    if named == ["none"]:
        return ()
    for name in named:
        if name not in EXPORTS:
            hint = suggestion(name, (*EXPORTS, "none"))
            raise BenchError(f"{name[:40]}: no such format{hint}")
    for name in named:
        label = EXPORTS_NEED.get(name)
        if label is not None and label not in labels:
            raise BenchError(f"{name}: is made of the label {label}, which is left out")
    return tuple(name for name in EXPORTS if name in named)
