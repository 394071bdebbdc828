"""The command line: parses, calls one function, prints. Heavy modules are imported by the verb."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, TextIO, cast

import typer

from pjpdaf.errors import BenchError
from scenarios.cli.dataset import app as dataset_app

app = typer.Typer(
    name="pjpdaf-bench",
    help="Render a seated person from two calibrated cameras, track head and both hands in 3-D, "
    "and score the result against the exact truth.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
scenarios_app = typer.Typer(help="The catalogue of scenarios.", no_args_is_help=True)
app.add_typer(scenarios_app, name="scenarios")
plugin_app = typer.Typer(help="Trackers and detectors of your own.", no_args_is_help=True)
app.add_typer(plugin_app, name="plugin")
app.add_typer(dataset_app, name="dataset")

PresetName = Annotated[
    str, typer.Option(help="Detector and tracker of this preset: thesis, thesis-literal.")
]
PartName = Annotated[str | None, typer.Option(help="Preset, entry point or module:factory.")]


def _version(value: bool) -> None:
    if value:
        from importlib.metadata import version

        typer.echo(f"pjpdaf-bench {version('pjpdaf-bench')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
def run(
    targets: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SCENARIO|SUITE]...", help="Names, or YAML files."),
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(help="Episodes of each scenario, seeds 0 to N-1 [the suite's own; 10]."),
    ] = None,
    preset: PresetName = "thesis",
    detector: PartName = None,
    tracker: PartName = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a scenario parameter, or detector.NAME / tracker.NAME. Repeatable.",
        ),
    ] = None,
    jobs: Annotated[int | None, typer.Option(help="Worker processes [all cores].")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the saved run [runs/NAME-DATE-TIME].")
    ] = None,
    first_seed: Annotated[int, typer.Option(help="Where the seeds start.")] = 0,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Only this of what is named; as in the table."),
    ] = None,
    slim: Annotated[
        bool, typer.Option("--slim", help="Keep only what `compare` needs: no frames, no page.")
    ] = False,
    films: Annotated[
        bool,
        typer.Option(
            "--films",
            help="Keep small films of every scenario's first seed and of the worst episodes; the "
            "page plays them.",
        ),
    ] = False,
    time_limit: Annotated[
        float, typer.Option(help="How long one episode may take [s]; then it has failed.")
    ] = 900.0,
    from_: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="DIR",
            help="Instead: the sequences of a data set; nothing is rendered.",
        ),
    ] = None,
) -> None:
    """Play scenarios, score them, print the table, save the run and its report.

    Without a name: the suite smoke.
    """
    from scenarios.run.run import RunRequest, run_suite

    run_suite(
        RunRequest(
            targets=tuple(targets or (() if from_ else ("smoke",))),
            dataset=from_,
            seeds=seeds,
            detector=detector or preset,
            tracker=tracker or preset,
            preset=preset,
            settings=tuple(settings or ()),
            jobs=jobs,
            out=out,
            argv=tuple(sys.argv[1:]),
            first_seed=first_seed,
            only=tuple(only or ()),
            slim=slim,
            films=films,
            time_limit_s=time_limit,
        )
    )


@app.command()
def compare(
    base: Annotated[Path, typer.Argument(metavar="BASE", help="Folder of a saved run.")],
    new: Annotated[Path, typer.Argument(metavar="NEW", help="Another, that must not be worse.")],
    margins: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="YAML file with margins: `margins: {error_mm: 2.5}`."),
    ] = None,
    margin: Annotated[
        list[str] | None,
        typer.Option(metavar="METRIC=VALUE", help="How much worse it may be. Repeatable."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the verdict's files [NEW].")] = None,
    escalate: Annotated[
        bool,
        typer.Option("--escalate", help="Where inconclusive: play more seeds of both."),
    ] = False,
    jobs: Annotated[
        int | None, typer.Option(help="With --escalate: worker processes [all cores].")
    ] = None,
) -> None:
    """The gate: a paired verdict on two saved runs, per metric.

    Writes verdict.json, junit.xml, summary.md, badge.json. Exit code 0: no worse; 1: worse; 3:
    inconclusive; 4: the runs did not play the same.
    """
    from scenarios.run.compare import CompareRequest, compare_runs

    raise typer.Exit(
        compare_runs(
            CompareRequest(
                base=base,
                new=new,
                margins_file=margins,
                margins=tuple(margin or ()),
                out=out,
                escalate=escalate,
                jobs=jobs,
                argv=tuple(sys.argv[1:]),
            )
        )
    )


@app.command()
def baseline(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a saved run.")],
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Folder of the slim copy.")],
    replace: Annotated[bool, typer.Option("--replace", help="A run may lie there.")] = False,
) -> None:
    """Keep of a saved run only what `compare` needs, small enough for git."""
    from reports.run.load import load
    from reports.run.save import save_slim

    typer.echo(f"baseline: {save_slim(load(run_folder), out, force=replace)}")


@plugin_app.command("check")
def plugin_check(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Entry point or module:factory.")],
    kind: Annotated[str, typer.Option(help="tracker or detector.")] = "tracker",
    limit: Annotated[float, typer.Option(help="How long one call may take [s].")] = 10.0,
) -> None:
    """Say what is wrong with a tracker or detector of your own, a line each; exit code 1 then."""
    from pjpdaf.plugins.conformance import LONGEST_LIMIT_S, check_named
    from scenarios.execute.isolated import Ended, isolated
    from scenarios.run.run import find_plug_ins_here

    find_plug_ins_here(name)
    try:
        # A call has a limit of its own; the whole has one for what hangs between the calls.
        what = f"{kind} {name!r}"
        faults = isolated(what, LONGEST_LIMIT_S, check_named, kind, name, limit)
    except Ended as end:
        faults = (str(end),)
    for fault in faults:
        typer.echo(fault)
    if faults:
        raise typer.Exit(1)
    typer.echo(f"ok: {kind} {name}")


@app.command()
def report(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Folders of saved runs.")],
    out: Annotated[
        Path | None, typer.Option(help="Where the page goes [RUN/report.html, of one run].")
    ] = None,
    rerun: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.rrd",
            help="Instead of a page: a recording of one run for the viewer Rerun.",
        ),
    ] = None,
) -> None:
    """Make the report page of a saved run again, or one page of several side by side.

    With --rerun a new file with cameras, films, paths, errors and events instead, to be opened with
    `rerun FILE.rrd`; needs the extra `viz`.
    """
    if rerun is not None:
        if len(runs) != 1 or out is not None:
            raise BenchError("--rerun takes one run, and goes without --out.")
        from reports.page.rerun import write_rerun
        from reports.run.load import load
        from scenarios.catalogue.film import told_of_signals

        with told_of_signals(rerun):
            typer.echo(f"recording: {write_rerun(load(runs[0]), rerun)}")
        return
    from scenarios.run.run import remake_report

    typer.echo(f"report: {remake_report(runs, out)}")


@app.command()
def score(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="Folder of a data set.")],
    tracks: Annotated[
        Path,
        typer.Argument(metavar="TRACKS", help="CSV or Parquet, or a folder with one a sequence."),
    ],
    out: Annotated[
        Path | None, typer.Option(help="Folder of the saved run [runs/NAME-DATE-TIME].")
    ] = None,
    frame: Annotated[
        str,
        typer.Option(help="Of positions: world, or left (the left camera's, as `track` writes)."),
    ] = "world",
) -> None:
    """Score anyone's tracks on a data set, save them as a run with its report.

    Columns: sequence, frame (from 0), target, x_m, y_m, z_m; status, sd_x_m, sd_y_m, sd_z_m if
    known. Missing rows count as lost.
    """
    from scenarios.tracks.score import ScoreRequest, score_tracks

    score_tracks(ScoreRequest(dataset, tracks, out, frame, tuple(sys.argv[1:])))


@app.command()
def track(
    left: Annotated[
        Path, typer.Option(metavar="DIR|VIDEO", help="Left view: folder, pattern or video.")
    ],
    right: Annotated[Path, typer.Option(metavar="DIR|VIDEO", help="Right view, likewise.")],
    calibration: Annotated[
        tuple[Path, Path],
        typer.Option(
            metavar="INTRINSICS EXTRINSICS", help="Files as OpenCV's stereo sample writes them."
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="New folder for all results.")],
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
    fps: Annotated[
        float | None, typer.Option(help="Frames a second [the video's own; 3 for folders].")
    ] = None,
    preset: PresetName = "thesis",
    detector: PartName = None,
    tracker: PartName = None,
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
) -> None:
    """Track head and hands in real footage: tracks.csv, tracks.parquet, overlay film, report page.

    Positions are in the left camera's frame (OpenCV: x right, y down, z forward), in metres.
    """
    from scenarios.footage.track import TrackRequest
    from scenarios.footage.track import track as track_footage

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
            detector=detector or preset,
            tracker=tracker or preset,
            settings=tuple(settings or ()),
            skin_sample=skin_sample,
            unit=unit,
            out=out,
            argv=tuple(sys.argv[1:]),
        )
    )


@app.command()
def calibrate(
    left: Annotated[
        Path, typer.Option(metavar="DIR|VIDEO", help="Left view: folder, pattern or video.")
    ],
    right: Annotated[Path, typer.Option(metavar="DIR|VIDEO", help="Right view, likewise.")],
    board: Annotated[
        str, typer.Option(metavar="9x6", help="Inner corners of the board, columns x rows.")
    ],
    square: Annotated[float, typer.Option(metavar="M", help="Side of a square [m].")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="New folder for all results.")],
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

    Writes intrinsics.yml and extrinsics.yml as OpenCV's stereo sample does, the corners found, and
    a rectified pair.
    """
    from scenarios.footage.calibrate import CalibrateRequest
    from scenarios.footage.calibrate import calibrate as calibrate_cameras

    calibrate_cameras(
        CalibrateRequest(left, right, board, square, charuco, marker, coefficients, out)
    )


@app.command()
def doctor() -> None:
    """Say whether this machine can run everything, and what to install where it cannot."""
    from scenarios.cli.doctor import examine

    findings = examine()
    for finding in findings:
        mark = "ok  " if finding.good else "FAIL"
        typer.echo(f"{mark} {finding.what}: {finding.found}")
        if finding.remedy:
            typer.echo(f"     -> {finding.remedy}")
    if not all(finding.good for finding in findings):
        raise typer.Exit(5)


@scenarios_app.command("list")
def scenarios_list(
    html: Annotated[
        Path | None,
        typer.Option(metavar="OUT.html", help="Instead: one page with a picture of each scenario."),
    ] = None,
    markdown: Annotated[
        Path | None,
        typer.Option(metavar="OUT.md", help="Instead: the same as Markdown, pictures beside it."),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Worker processes for the pictures [all cores].")
    ] = None,
) -> None:
    """All shipped scenarios and suites: group, frames x frames a second, T if from the thesis."""
    if html is None and markdown is None:
        from scenarios.catalogue.list_text import lines

        for line in lines():
            typer.echo(line)
        return
    from scenarios.catalogue.pages import write_catalogue
    from scenarios.run.run import worker_count

    for path in write_catalogue(html, markdown, worker_count(jobs)):
        typer.echo(f"catalogue: {path}")


@scenarios_app.command("show")
def scenarios_show(
    name: Annotated[str, typer.Argument(metavar="SCENARIO", help="Name, or YAML file.")],
    seed: Annotated[int, typer.Option(help="The seed whose drawn values are shown.")] = 0,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a scenario parameter. Repeatable.",
        ),
    ] = None,
    film: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.mp4|OUT.png",
            help="Film it with its truth drawn in, or put twelve frames on one sheet.",
        ),
    ] = None,
    frames: Annotated[
        str | None, typer.Option(metavar="A:B", help="With --film: only frames A to B.")
    ] = None,
) -> None:
    """A scenario's parameters: unit, range, distribution, and the values that a seed draws.

    With --film both views instead, with the exact truth: outline of the visible skin, projected
    centre and its path, visible share, merged targets, events.
    """
    if film is None:
        if frames:
            raise BenchError("--frames is for a film: give --film OUT.mp4 or OUT.png.")
        from scenarios.catalogue.describe import describe
        from scenarios.catalogue.film import scenario_settings

        describe(name, seed, scenario_settings(tuple(settings or ())))
        return
    from scenarios.catalogue.film import ShowRequest, show

    typer.echo(show(ShowRequest(name, seed, tuple(settings or ()), film, frames)))


@scenarios_app.command("measure")
def scenarios_measure(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENARIO]...", help="Names, or YAML files.")
    ] = None,
    seeds: Annotated[int, typer.Option(help="Draws of each scenario, seeds 0 to N-1.")] = 3,
) -> None:
    """Could a person do it? Penetration, reach, joints, speeds, before anything is rendered.

    Without a name: the whole catalogue. Exit code 1 if a limit is passed.
    """
    from rich.console import Console

    from scenarios.catalogue.survey import survey, survey_table
    from scenarios.spec.names import load_scenario, scenario_names

    if not 1 <= seeds <= 1000:
        raise BenchError(f"--seeds must be between 1 and 1000, got {seeds}")
    surveys = [survey(load_scenario(n), range(seeds)) for n in names or scenario_names()]
    console = Console()
    # A pipe has no width: the table is kept whole there.
    console = console if console.is_terminal else Console(width=140)
    console.print(survey_table(surveys))
    if any(found.faults for found in surveys):
        raise typer.Exit(1)


@scenarios_app.command("validate")
def scenarios_validate(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Scenario files.")],
) -> None:
    """Check scenario files; every fault with its line and column. Exit code 2 if there is any."""
    from scenarios.spec.loader import load_scenario_file

    faulty = False
    for file in files:
        try:
            scenario = load_scenario_file(file)
        except BenchError as fault:
            typer.echo(str(fault), err=True)
            faulty = True
        else:
            typer.echo(f"{file}: ok ({scenario.name}, {len(scenario.parameters)} parameters)")
    if faulty:
        raise typer.Exit(2)


@scenarios_app.command("schema")
def scenarios_schema() -> None:
    """The JSON schema of a scenario file, for editors."""
    import json

    from scenarios.spec.loader import json_schema

    typer.echo(json.dumps(json_schema(), indent=2))


class _Stream:
    """Standard output or error that outlives its reader (| head).

    What nobody reads is thrown away; the work goes on to its end and keeps its exit code.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            self._turn_away()
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._turn_away()

    def _turn_away(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)


@contextmanager
def _outliving_readers() -> Iterator[None]:
    before = sys.stdout, sys.stderr
    # A stream that was closed from the start (>&-) is None, and may stay it.
    sys.stdout, sys.stderr = (s and cast(TextIO, _Stream(s)) for s in before)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        sys.stdout, sys.stderr = before


def main() -> None:
    """Entry point: a fault that the user can put right is one line and an exit code."""
    with _outliving_readers():
        _run_app()


def _run_app() -> None:
    try:
        app(standalone_mode=True)
    except BenchError as fault:
        sys.stderr.write(f"pjpdaf-bench: {fault}\n")
        raise SystemExit(fault.exit_code) from None
    except KeyboardInterrupt:
        sys.stderr.write("pjpdaf-bench: interrupted\n")
        raise SystemExit(130) from None
    except OSError as fault:
        if fault.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stderr.write(f"pjpdaf-bench: cannot write the output: {fault.strerror}\n")
        raise SystemExit(5) from None


if __name__ == "__main__":
    main()
