"""The verbs of `scenarios`: list, show, sheet, measure, validate, schema, clip."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pjpdaf.errors import BenchError
from scenarios.cli.help import SentenceGroup
from scenarios.cli.options import ScenarioSettings

app = typer.Typer(cls=SentenceGroup, help="The catalogue of scenarios.", no_args_is_help=True)


@app.command("list")
def list_catalogue(
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
        from shutil import get_terminal_size

        from scenarios.catalogue.list_text import WIDTH, catalogue_lines

        for line in catalogue_lines(get_terminal_size((WIDTH, 24)).columns):
            typer.echo(line)
        return
    from scenarios.catalogue.pages import write_catalogue
    from scenarios.execute.local import worker_count

    for path in write_catalogue(html, markdown, worker_count(jobs)):
        typer.echo(f"catalogue: {path}")


@app.command("show")
def show(
    name: Annotated[str, typer.Argument(metavar="SCENARIO", help="Name, or YAML file.")],
    seed: Annotated[int, typer.Option(help="The seed whose drawn values are shown.")] = 0,
    settings: ScenarioSettings = None,
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
        from scenarios.catalogue.describe import print_description
        from scenarios.play.settings import read_scenario_settings

        print_description(name, seed, read_scenario_settings(tuple(settings or ())))
        return
    from scenarios.catalogue.film import FilmRequest, film_scenario

    typer.echo(film_scenario(FilmRequest(name, seed, tuple(settings or ()), film, frames)))


@app.command("sheet")
def sheet(
    targets: Annotated[
        list[str], typer.Argument(metavar="SCENARIO|SUITE", help="Names, or YAML files.")
    ],
    out: Annotated[Path, typer.Option(metavar="OUT.webp|.jpg|.png", help="The sheet.")],
    pictures: Annotated[int, typer.Option(help="How many episodes.")] = 24,
    seeds: Annotated[int | None, typer.Option(help="Seeds of each scenario [a suite's].")] = None,
    first_seed: Annotated[int, typer.Option(help="The first of them.")] = 0,
    settings: ScenarioSettings = None,
) -> None:
    """A sheet of small pictures: the left view in the middle of each of the first episodes."""
    from scenarios.catalogue.sheet import SheetRequest, write_sheet

    request = SheetRequest(tuple(targets), pictures, seeds, first_seed, tuple(settings or ()), out)
    typer.echo(write_sheet(request))


@app.command("measure")
def measure(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="SCENARIO", help="Names, or YAML files.")
    ] = None,
    seeds: Annotated[int, typer.Option(help="Draws of each scenario, seeds 0 to N-1.")] = 3,
) -> None:
    """Could a person do it? Penetration, reach, joints, speeds, before anything is rendered.

    Without a name: the whole catalogue. Exit code 1 if a limit is passed.
    """
    from scenarios.catalogue.survey import survey_scenario
    from scenarios.catalogue.survey_table import survey_table
    from scenarios.console.progress import progress
    from scenarios.console.tables import print_table
    from scenarios.spec.motion.plugged import trust
    from scenarios.spec.names import load_scenario, scenario_names
    from sim.steps import counted

    if not 1 <= seeds <= 1000:
        raise BenchError(f"--seeds must be between 1 and 1000, got {seeds}")
    trust(*(names or ()))
    scenarios = [load_scenario(name) for name in names or scenario_names()]
    with progress() as meter:
        meter.begin("measuring", len(scenarios), "scenario")
        surveys = [survey_scenario(one, range(seeds)) for one in counted(scenarios)]
    print_table(survey_table(surveys))
    if any(survey.faults for survey in surveys):
        raise typer.Exit(1)


@app.command("validate")
def validate(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Scenario files.")],
) -> None:
    """Check scenario files; every fault with its line and column. Exit code 2 if there is any.

    A script is planned as well, for seed 0: times that overlap, places out of reach.
    """
    from scenarios.catalogue.validation import validated

    faulty = False
    for file in files:
        try:
            typer.echo(validated(file))
        except BenchError as fault:
            typer.echo(str(fault), err=True)
            faulty = True
    if faulty:
        raise typer.Exit(2)


@app.command("schema")
def schema() -> None:
    """The JSON schema of a scenario file, for editors."""
    import json

    from scenarios.spec.schema import json_schema

    typer.echo(json.dumps(json_schema(), indent=2))


@app.command("clip")
def clip(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An .npz, .csv or .bvh file.")],
    unit: Annotated[
        str | None,
        typer.Option(help="Unit of a BVH file: mm, cm, m, inch, or a number of metres [guessed]."),
    ] = None,
    begin: Annotated[float, typer.Option(help="Where it begins [s].")] = 0.0,
    end: Annotated[float | None, typer.Option(help="Where it ends [s].")] = None,
    out: Annotated[Path | None, typer.Option(help="Write it in metres to this .npz file.")] = None,
) -> None:
    """Say what a clip of recorded motion is; for `--set clip=FILE` of the scenario `recorded`."""
    from scenarios.catalogue.clip import ClipRequest, describe_clip

    for line in describe_clip(ClipRequest(file, unit, begin, end, out)):
        typer.echo(line)
