"""The verb `map`: failures over one parameter or two, and the page that shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from rich.console import Console

from pjpdaf.errors import BenchError
from reports.score.robustness import GOALS
from reports.stress.load import MAP_EPISODES
from reports.stress.page import write_stress_page
from reports.stress.records import EpisodeKey, MapFile, MapRecord, write_record
from reports.stress.words import share_text
from reports.summary.text import count
from reports.words import GOAL_WORDS
from scenarios.console.lines import print_line
from scenarios.stress.campaign import Campaign, CampaignRequest, open_campaign, spaces_of
from scenarios.stress.case import Case, Trial, TrialResult
from scenarios.stress.map.cells import MOST_CELLS, grid
from scenarios.stress.map.explore import MapPlan, PlayedCell, axes_of, check_runs, explore
from scenarios.stress.map.record import map_record
from scenarios.stress.quarantine import name_quarantined, quarantine_fields
from scenarios.stress.recording import Shown, record_episodes
from scenarios.stress.space import Space
from scenarios.stress.system_text import command_text, replay_command, system_text

MOST_EPISODES = 400


@dataclass(frozen=True)
class MapRequest:
    """The options of `map`. episodes: trials of each map that the page plays."""

    campaign: CampaignRequest
    plan: MapPlan
    episodes: int = 60
    argv: tuple[str, ...] = ()


def map_verb(request: MapRequest) -> None:
    """Play the map of each family, print it, write map.json and the page.

    Raises BenchError, and Interrupted after a signal: the same command goes on.
    """
    plan = request.plan
    check_plan(plan)
    if not 0 <= request.episodes <= MOST_EPISODES:
        raise BenchError(
            f"--episodes must be between 0 and {MOST_EPISODES}, got {request.episodes}"
        )
    axes = tuple(name for name in (plan.x, plan.y) if name is not None)
    wanted = replace(
        request.campaign,
        also=tuple(dict.fromkeys((*request.campaign.also, *axes))),
        options={**asdict(plan), "episodes": request.episodes},
    )
    check_spaces(spaces_of(wanted), plan)
    with open_campaign(wanted) as campaign:
        records, shown = [], []
        for space in campaign.spaces:
            record, more = _mapped(campaign, space, request)
            records.append(record)
            shown += more
        record_episodes(campaign, shown, MAP_EPISODES)
        file = MapFile(
            system=system_text(campaign.system),
            maps=tuple(records),
            **quarantine_fields(campaign),
        )
        write_record(campaign.folder / "map.json", file)
        page = write_stress_page([campaign.folder], campaign.folder / "stress.html")
    out = Console()
    for record in records:
        print_line(_summary(record), out)
    print_line(f"page: {page}", out)
    name_quarantined(campaign, out)


def check_plan(plan: MapPlan) -> None:
    """Raise BenchError for numbers that no map has."""
    for name, value, least, most in (
        ("cells", plan.cells, 1, MOST_CELLS),
        ("seeds", plan.seeds, 1, 1000),
        ("refine", plan.refine, 0, 4),
    ):
        if not least <= value <= most:
            raise BenchError(f"--{name} must be between {least} and {most}, got {value}")
    if not 0.0 < plan.level < 1.0:
        raise BenchError(f"--level must be above 0 and below 1, got {plan.level:g}")
    if plan.x == plan.y:
        raise BenchError(f"--x and --y are both {plan.x}; a map needs two parameters")


def check_spaces(spaces: Sequence[Space], plan: MapPlan) -> None:
    """Raise BenchError where a family has no such map, before anything is played."""
    for space in spaces:
        x, y = axes_of(space, plan)
        check_runs(len(grid(x, y, plan.cells)), plan)


def _mapped(campaign: Campaign, space: Space, request: MapRequest) -> tuple[MapRecord, list[Shown]]:
    """The map of a family, and the trials that the page plays."""
    plan, name = request.plan, space.family.name
    fidelity = campaign.fidelity_for(space)
    campaign.progress.start(f"{name}: map")

    def evaluate(cases: Sequence[Case]) -> Sequence[TrialResult]:
        trials = [Trial(case, campaign.system, fidelity) for case in cases]
        campaign.progress.expect(len(trials))
        return campaign.runner.run(trials)

    cells, runs = explore(space, plan, evaluate)
    shown: list[Shown] = []
    keys: dict[int, EpisodeKey] = {}
    commands: dict[int, str] = {}
    for place in _chosen(cells, plan, request.episodes):
        case = cells[place].cases[cells[place].shown(plan.goal)]
        words = " ".join(f"{n} {case.values[n]}" for n in (plan.x, plan.y) if n is not None)
        trial = Trial(case, campaign.system, fidelity)
        shown.append(Shown(f"{name}: {words}", trial))
        keys[place] = shown[-1].key
        commands[place] = replay_command(trial)
    record = map_record(
        space, plan, fidelity, cells, runs, keys, commands, command_text(request.argv)
    )
    return record, shown


def _chosen(cells: Sequence[PlayedCell], plan: MapPlan, most: int) -> list[int]:
    """Places of the cells whose trial is kept: those that failed before others, evenly spread."""
    places = [n for n, cell in enumerate(cells) if cell.played]
    failed = [n for n in places if cells[n].failures(plan.goal)]
    if len(failed) >= most:
        return sorted({failed[i * len(failed) // most] for i in range(most)})
    others = [n for n in places if n not in set(failed)]
    left = min(most - len(failed), len(others))
    return sorted([*failed, *(others[i * len(others) // left] for i in range(left))])


def _summary(record: MapRecord) -> str:
    n = sum(cell.n for cell in record.cells)
    shares = ", ".join(
        f"{GOAL_WORDS[goal]} {share_text(failed / n)}"
        for goal in GOALS
        if (failed := sum(cell.failures[goal] for cell in record.cells)) and n
    )
    axes = record.x.name if record.y is None else f"{record.x.name} x {record.y.name}"
    unplayed = f", {record.unplayed} without a result" if record.unplayed else ""
    return (
        f"{record.family}: {axes}, {count(len(record.cells), 'cell')}, "
        f"{count(record.runs, 'run')} in {record.fidelity}; of the cells' "
        f"{count(n + record.unplayed, 'trial')}: {shares or 'none failed'}{unplayed}"
    )
