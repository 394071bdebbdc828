"""The verb `compare`: two trackers on common draws, and where they differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from rich.console import Console
from rich.table import Table

from pjpdaf.errors import BenchError, InfrastructureError
from reports.score.robustness import Goal, measures_of
from reports.stress.page import write_stress_page
from reports.stress.records import CompareFile, CompareRecord, MapRecord, write_record
from reports.summary.plain_table import plain_table
from scenarios.console.lines import print_line
from scenarios.console.tables import print_table
from scenarios.play.job import System
from scenarios.stress.campaign import Campaign, CampaignRequest, open_campaign, spaces_of
from scenarios.stress.case import Case, Trial, TrialResult
from scenarios.stress.estimate.outcomes import noise_seeds, normal_draws
from scenarios.stress.map.explore import MapPlan, explore
from scenarios.stress.map.record import map_record
from scenarios.stress.map_verb import check_plan, check_spaces
from scenarios.stress.paired import paired_failures
from scenarios.stress.quarantine import name_quarantined, quarantine_fields
from scenarios.stress.search_verb import goals_of
from scenarios.stress.space import Space
from scenarios.stress.system_text import command_text, system_text

MOST_RUNS = 1_000_000


@dataclass(frozen=True)
class CompareRequest:
    """The options of `compare`: the campaign's tracker is A, its `against` is B.

    goals: as in `estimate`; runs: common draws of each family; plan: of a difference map, None
    without one.
    """

    campaign: CampaignRequest
    goals: str = "swap,lost"
    runs: int = 200
    plan: MapPlan | None = None
    argv: tuple[str, ...] = ()


def difference_plan(
    x: str | None, y: str | None, cells: int, seeds: int, seed: int, find: str
) -> MapPlan | None:
    """The plan of the difference map, None without axes. Raises BenchError for one axis alone."""
    if x is None and y is None:
        return None
    if x is None or y is None:
        raise BenchError("a map of the difference needs both --x and --y")
    return MapPlan(x, y, cells, seeds, refine=0, goal=goals_of(find)[0], seed=seed)


def compare_verb(request: CompareRequest) -> None:
    """Compare, print the table, write compare.json and the page. Raises as `map_verb`."""
    goals = goals_of(request.goals)
    if not 1 <= request.runs <= MOST_RUNS:
        raise BenchError(f"--runs must be between 1 and {MOST_RUNS}, got {request.runs}")
    axes: tuple[str, ...] = ()
    if request.plan is not None:
        check_plan(request.plan)
        axes = tuple(n for n in (request.plan.x, request.plan.y) if n is not None)
    if request.campaign.other == request.campaign.system:
        raise BenchError("compare needs two systems, got the same twice")
    wanted = replace(
        request.campaign,
        also=tuple(dict.fromkeys((*request.campaign.also, *axes))),
        options={
            "goals": goals,
            "runs": request.runs,
            "plan": asdict(request.plan) if request.plan is not None else None,
        },
    )
    if request.plan is not None:
        check_spaces(spaces_of(wanted), request.plan)
    with open_campaign(wanted) as campaign:
        records = [
            record for space in campaign.spaces for record in _compared(campaign, space, request)
        ]
        names = f"{records[0].a} and {records[0].b}"
        write_record(
            campaign.folder / "compare.json",
            CompareFile(system=names, comparisons=tuple(records), **quarantine_fields(campaign)),
        )
        page = write_stress_page([campaign.folder], campaign.folder / "stress.html")
    out = Console()
    print_table(_table(records), out)
    print_line(f"page: {page}", out)
    name_quarantined(campaign, out)
    if not any(r.both + r.only_a + r.only_b + r.neither for r in records):
        raise InfrastructureError("no draw gave a result with both trackers")


def _compared(campaign: Campaign, space: Space, request: CompareRequest) -> list[CompareRecord]:
    """The comparison of a family, a record for each goal."""
    a, b = campaign.system, campaign.other
    assert b is not None, "the request names both"
    name, seed = space.family.name, campaign.request.seed
    campaign.progress.start(f"{name}: common draws", 2 * request.runs)
    latents = normal_draws(seed, f"{name}/compare", request.runs, len(space.axes))
    seeds = noise_seeds(seed, f"{name}/compare", request.runs).tolist()
    target = space.family.target
    cases = [
        Case(target, space.values_of_latent(z), s) for z, s in zip(latents, seeds, strict=True)
    ]
    ones, others = (_run(campaign, space, cases, system) for system in (a, b))
    pairs = [
        (one, other)
        for one, other in zip(ones, others, strict=True)
        if one.robustness is not None and other.robustness is not None
    ]
    records = []
    for goal in goals_of(request.goals):
        counts = paired_failures(
            [_failed(one, goal) for one, _ in pairs], [_failed(other, goal) for _, other in pairs]
        )
        maps: tuple[MapRecord | None, MapRecord | None] = (None, None)
        if request.plan is not None and goal == request.plan.goal:
            maps = (
                _mapped(campaign, space, request.plan, a),
                _mapped(campaign, space, request.plan, b),
            )
        records.append(
            CompareRecord(
                family=name,
                goal=goal,
                fidelity=campaign.fidelity_for(space),
                a=system_text(a),
                b=system_text(b),
                **asdict(counts),
                map_a=maps[0],
                map_b=maps[1],
                command=command_text(request.argv),
            )
        )
    return records


def _mapped(campaign: Campaign, space: Space, plan: MapPlan, system: System) -> MapRecord:
    """The map of a system; never refined, so that both have the same cells and draws."""
    campaign.progress.start(f"{space.family.name}: map of {system_text(system)}")
    even = replace(plan, refine=0)

    def evaluate(cases: Sequence[Case]) -> Sequence[TrialResult]:
        campaign.progress.expect(len(cases))
        return _run(campaign, space, cases, system)

    cells, runs = explore(space, even, evaluate)
    return map_record(space, even, campaign.fidelity_for(space), cells, runs, {}, {}, "")


def _run(
    campaign: Campaign, space: Space, cases: Sequence[Case], system: System
) -> list[TrialResult]:
    fidelity = campaign.fidelity_for(space)
    return campaign.runner.run([Trial(case, system, fidelity) for case in cases])


def _failed(result: TrialResult, goal: Goal) -> bool:
    return any(name in measures_of((goal,)) for name in result.failed)


def _table(records: Sequence[CompareRecord]) -> Table:
    table = plain_table()
    for heading in ("family", "of"):
        table.add_column(heading, no_wrap=True)
    for heading in ("both", "A", "B", "none", "P(B) - P(A) [%]", "p"):
        table.add_column(heading, justify="right", no_wrap=True)
    for r in records:
        table.add_row(
            r.family,
            r.goal,
            *(str(n) for n in (r.both, r.only_a, r.only_b, r.neither)),
            f"{100 * r.difference:+.1f} ({100 * r.low:+.1f} to {100 * r.high:+.1f})",
            f"{r.p_value:.1g}",
        )
    if records:
        table.caption = f"failed: both, A = {records[0].a} only, B = {records[0].b} only, none"
    return table
