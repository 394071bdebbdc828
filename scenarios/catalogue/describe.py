"""The table of `scenarios show`: a scenario's parameters, or a suite's entries."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rich.console import Console
from rich.table import Table

from reports.summary.plain_table import plain_table
from reports.summary.text import count
from scenarios.console.lines import print_line
from scenarios.console.tables import print_table
from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import resolve, scenarios_of
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.distributions import Fixed, Normal
from scenarios.spec.parameters.file import File
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.parameter import Parameter
from scenarios.spec.scenario import Scenario, digest
from scenarios.spec.suite import Suite, suite_digest


def print_description(name: str, seed: int, overrides: Mapping[str, str] | None = None) -> None:
    """Print a scenario's parameters with the values of a seed, or a suite's entries.

    overrides: parameters of the scenario that are set. Raises BenchError.
    """
    described = resolve(name)
    if isinstance(described, Suite):
        _print(_suite_head(described), _suite_table(described))
    else:
        _print(_scenario_head(described), _scenario_table(described, seed, overrides or {}))


def _print(lines: Iterable[str], table: Table) -> None:
    console = Console()
    for line in lines:
        print_line(line, console)
    print_table(table, console)


def _scenario_table(scenario: Scenario, seed: int, overrides: Mapping[str, str]) -> Table:
    redrawn = perform(scenario, seed, overrides).redrawn
    values = concrete(scenario, seed, overrides, redrawn)
    table = plain_table()
    for column in ("parameter", "unit", "range", "nominal", f"seed {seed}", "meaning"):
        table.add_column(column, overflow="fold")
    for key, parameter in scenario.parameters.items():
        value = values[key]
        shown = value if isinstance(value, str) else f"{float(value):.4g}"
        table.add_row(key, *_cells(parameter), shown, parameter.meaning)
    return table


def _suite_head(suite: Suite) -> Iterator[str]:
    members = {scenario.name: scenario for _, scenario in scenarios_of(suite)}
    yield f"{suite.name} (suite, version {suite.version})"
    yield suite.summary
    yield f"{len(suite.scenarios)} entries, {count(suite.seeds, 'seed')} each unless the entry says"
    yield f"digest: {suite_digest(suite, members)}"
    yield ""


def _suite_table(suite: Suite) -> Table:
    table = plain_table()
    for column in ("entry", "scenario", "version", "frames", "seeds"):
        table.add_column(column, no_wrap=True)
    table.add_column("set", overflow="fold")
    for entry, scenario in scenarios_of(suite):
        frames, rates = entry.frames or scenario.frames, scenario.rates
        length = f"{frames} x {scenario.fps:g}"
        if rates:
            length = f"{frames / scenario.fps:g} s x {len(rates)} rates"
        table.add_row(
            entry.label or scenario.name,
            scenario.name,
            str(scenario.version),
            length,
            str(entry.seeds or suite.seeds),
            ", ".join(f"{key}={value}" for key, value in entry.overrides.items()),
        )
    return table


def _scenario_head(scenario: Scenario) -> Iterator[str]:
    yield f"{scenario.name} (version {scenario.version}, group {scenario.group})"
    yield scenario.summary
    if scenario.thesis:
        yield f"thesis: {scenario.thesis}"
    length = f"{count(scenario.frames, 'frame')} at {scenario.fps:g} a second"
    if scenario.rates:
        rates = ", ".join(f"{rate:g}" for rate in scenario.rates)
        length = f"{scenario.frames / scenario.fps:g} s at {rates} frames a second each"
    yield f"{length}, {scenario.background_frames} background frames"
    yield f"digest: {digest(scenario)}"
    yield ""


def _cells(parameter: Parameter) -> tuple[str, str, str]:
    """Unit, range, nominal distribution."""
    if isinstance(parameter, Choice):
        weights = "" if parameter.weights is None else str(list(parameter.weights))
        return "", ", ".join(parameter.choices), weights or "equally likely"
    if isinstance(parameter, File):
        return "", "a file", parameter.file
    assert isinstance(parameter, Numeric)
    low, high = parameter.range
    nominal = parameter.nominal
    if isinstance(nominal, Fixed):
        distribution = f"{nominal.value:g}"
    elif isinstance(nominal, Normal):
        distribution = f"normal {nominal.mean:g} sd {nominal.sd:g}"
    else:
        distribution = "{} {:g} to {:g}".format(nominal.kind, *parameter.bounds)
    return parameter.unit, f"{low:g} to {high:g}", distribution
