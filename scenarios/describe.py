"""What a scenario is made of, as a table for people."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Console
from rich.table import Table

from scenarios.catalogue import load_scenario
from scenarios.concrete import concrete, perform
from scenarios.parameters import Choice, Fixed, Normal, Numeric, Parameter
from scenarios.spec import Scenario, digest


def describe(name: str, seed: int) -> None:
    """Print a scenario's head and parameters, with the values of one seed. Raises BenchError."""
    scenario = load_scenario(name)
    values = concrete(scenario, seed, redraw=perform(scenario, seed).redrawn)
    console = Console()
    for line in head(scenario):
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    table = Table(box=None, pad_edge=False)
    for column in ("parameter", "unit", "range", "nominal", f"seed {seed}", "meaning"):
        table.add_column(column, overflow="fold")
    for key, parameter in scenario.parameters.items():
        value = values[key]
        shown = value if isinstance(value, str) else f"{float(value):.4g}"
        table.add_row(key, *_cells(parameter), shown, parameter.meaning)
    console.print(table)


def head(scenario: Scenario) -> Iterator[str]:
    """The lines above the table."""
    yield f"{scenario.name} (version {scenario.version}, group {scenario.group})"
    yield scenario.summary
    if scenario.thesis:
        yield f"thesis: {scenario.thesis}"
    yield (
        f"{scenario.frames} frames at {scenario.fps:g} a second, "
        f"{scenario.background_frames} background frames"
    )
    yield f"digest: {digest(scenario)}"
    yield ""


def _cells(parameter: Parameter) -> tuple[str, str, str]:
    """Unit, range, nominal distribution."""
    if isinstance(parameter, Choice):
        weights = "" if parameter.weights is None else str(list(parameter.weights))
        return "", ", ".join(parameter.choices), weights or "equally likely"
    assert isinstance(parameter, Numeric)
    low, high = parameter.range
    nominal = parameter.nominal
    if isinstance(nominal, Fixed):
        said = f"{nominal.value:g}"
    elif isinstance(nominal, Normal):
        said = f"normal {nominal.mean:g} sd {nominal.sd:g}"
    else:
        said = "{} {:g} to {:g}".format(nominal.kind, *parameter.bounds)
    return parameter.unit, f"{low:g} to {high:g}", said
