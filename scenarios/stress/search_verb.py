"""The verb `search`: hunt the failures of a tracker, family by family, and confirm them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError
from reports.score.robustness import GOALS, Goal
from reports.stress.load import EPISODES
from reports.stress.page import write_stress_page
from reports.stress.records import SearchFile, write_record
from reports.stress.words import value_text
from reports.summary.text import count
from scenarios.console.lines import print_command, print_line
from scenarios.console.tables import print_table
from scenarios.spec.corpus_case import corpus_files, load_corpus_case
from scenarios.spec.suggestion import suggestion
from scenarios.stress.campaign import Campaign, CampaignRequest, open_campaign
from scenarios.stress.case import Case, Fidelity
from scenarios.stress.case_file import can_be_file, case_of, corpus_case, write_case
from scenarios.stress.confirm import MOST_RUNS, Counterexample, choose, confirm
from scenarios.stress.drawn import drawn_space
from scenarios.stress.quarantine import name_quarantined, quarantine_fields
from scenarios.stress.recording import record_episodes
from scenarios.stress.search.evaluation import Evaluation, Evaluator
from scenarios.stress.search.page_record import (
    failure_command,
    failure_name,
    search_record,
    shown_failures,
    shown_measure,
)
from scenarios.stress.search.record import KIND, VERSION, family_record
from scenarios.stress.search.search import FamilySearch, SearchPlan, search_family
from scenarios.stress.search.table import failure_table
from scenarios.stress.space import Space
from scenarios.stress.system_text import command_text, system_text
from sim.files import written_whole_file

MAX_BUDGET = 1_000_000
ALL_GOALS = "all"


@dataclass(frozen=True)
class SearchRequest:
    """The options of `search`. goals: `all`, or some of swap, head, lost with commas between.

    budget: trials a family of the system under test, in the fidelity of the search; distinct:
    failures a family that are enough; patience: trials without a new one that are enough; confirm:
    cases a family that are rendered; corpus: begin with the corpus's cases.
    """

    campaign: CampaignRequest
    goals: str = ALL_GOALS
    budget: int = 500
    distinct: int = 20
    patience: int = 2000
    confirm: int = 8
    corpus: bool = True
    argv: tuple[str, ...] = ()


@dataclass(frozen=True)
class FamilyFound:
    """A family's search and its counterexamples; files: of those that count, by number.

    fresh_runs: trials of the budget with fresh noise; other_runs: of the tracker to compare with.
    """

    search: FamilySearch
    found: tuple[Counterexample, ...]
    fidelity: Fidelity
    fresh_runs: int = 0
    other_runs: int = 0
    files: tuple[Path | None, ...] = ()

    @property
    def runs(self) -> int:
        """Trials in the fidelity of the search, all that the budget pays for."""
        return self.search.runs + self.fresh_runs

    @property
    def runs_text(self) -> str:
        """As "64 runs in fast: 32 points, 24 to see what matters, 8 with fresh noise"."""
        points = len(self.search.evaluations)
        parts = [count(points, "point")]
        if attributing := self.search.runs - points:
            parts.append(f"{attributing} to see what matters")
        if self.fresh_runs:
            parts.append(f"{self.fresh_runs} with fresh noise")
        split = f": {', '.join(parts)}" if len(parts) > 1 else ""
        other = f"; {self.other_runs} of the other tracker" if self.other_runs else ""
        return f"{count(self.runs, 'run')} in {self.fidelity}{split}{other}"


def search_verb(request: SearchRequest) -> None:
    """Search, confirm, print the table, write search.json and a file for each case.

    Raises BenchError, and Interrupted after a signal.
    """
    goals = goals_of(request.goals)
    for name in ("budget", "distinct", "patience"):
        if not 1 <= getattr(request, name) <= MAX_BUDGET:
            raise BenchError(
                f"--{name} must be between 1 and {MAX_BUDGET}, got {getattr(request, name)}"
            )
    if request.confirm < 0:
        raise BenchError(f"--confirm must be 0 or more, got {request.confirm}")
    options = {
        name: getattr(request, name)
        for name in ("goals", "budget", "distinct", "patience", "confirm", "corpus")
    }
    campaign_request = replace(request.campaign, options=options)
    with open_campaign(campaign_request) as campaign:
        results = [_search(campaign, space, request, goals) for space in campaign.spaces]
        results = [_with_files(campaign, result) for result in results]
        _write_record(campaign, results)
        page = _write_page(campaign, results, request.argv)
    out = Console()
    _print(campaign, results, out)
    print_line(f"page: {page}", out)
    name_quarantined(campaign, out)


def goals_of(text: str) -> tuple[Goal, ...]:
    """The goals of `--find`. Raises BenchError with the closest name."""
    if text == ALL_GOALS:
        return GOALS
    words = [word.strip() for word in text.split(",")]
    for word in words:
        if word not in GOALS:
            hint = suggestion(word, (*GOALS, ALL_GOALS))
            raise BenchError(f"--find {word[:60]}: unknown{hint}")
    return tuple(goal for goal in GOALS if goal in words)


def goal_of(text: str) -> Goal:
    """The one goal of `--find`. Raises BenchError."""
    goals = goals_of(text)
    if len(goals) != 1:
        raise BenchError(f"--find {text}: must be one of {', '.join(GOALS)}")
    return goals[0]


def known_cases(space: Space) -> tuple[Case, ...]:
    """The shipped corpus's cases of a family, inside its space; files of other versions are not.

    Drawn values that a case sets stay as they are.
    """
    drawn = drawn_space(space).names
    cases = []
    for path in corpus_files():
        record = load_corpus_case(path)
        if record.family == space.family.target:
            values = {**space.nominal(), **case_of(record).values}
            held = {name: value for name, value in values.items() if name in drawn}
            inside = space.values_of_unit(space.unit_of_values(values))
            cases.append(Case(record.family, {**held, **inside}, record.seed))
    return tuple(cases)


def _search(
    campaign: Campaign, space: Space, request: SearchRequest, goals: tuple[Goal, ...]
) -> FamilyFound:
    name, seed = space.family.name, campaign.request.seed
    fidelity = campaign.fidelity_for(space)
    evaluator = Evaluator(campaign.runner, campaign.system, fidelity, campaign.other)
    plan = SearchPlan(
        budget=request.budget,
        goals=goals,
        seed=seed,
        known=known_cases(space) if request.corpus else (),
        distinct=request.distinct,
        patience=request.patience,
        fresh=MOST_RUNS,
    )
    campaign.progress.start(f"{name}: search", request.budget)
    other_runs = 0

    def evaluate(cases: Sequence[Case]) -> list[Evaluation]:
        nonlocal other_runs
        evaluations = evaluator.evaluate(cases)
        other_runs += sum(evaluation.other is not None for evaluation in evaluations)
        return evaluations

    search = search_family(space, evaluate, plan)
    left = request.budget - search.runs
    campaign.progress.start(f"{name}: fresh noise", min(left, len(search.failures) * MOST_RUNS))
    found: list[Counterexample] = []
    for number, failure in enumerate(search.failures):
        found.append(choose(failure, evaluate, seed, number, min(left, MOST_RUNS)))
        left -= found[-1].runs
    most = min(request.confirm, len(found))
    campaign.progress.start(f"{name}: confirm", most)
    in_full = replace(evaluator, fidelity="full")
    fresh_runs = sum(one.runs for one in found)
    confirmed = tuple(confirm(found, in_full.evaluate, most))
    return FamilyFound(search, confirmed, fidelity, fresh_runs, other_runs)


def _with_files(campaign: Campaign, result: FamilyFound) -> FamilyFound:
    """Write a file for each case that counts, but for those with a file of the user's in them."""
    files: list[Path | None] = []
    folder = campaign.folder / "cases"
    folder.mkdir(exist_ok=True)
    for number, one in enumerate(result.found, start=1):
        robustness = one.result.robustness
        if not one.counts or robustness is None or not can_be_file(one.case):
            files.append(None)
            continue
        name = failure_name(one, number)
        measure = shown_measure(one)
        record = corpus_case(
            name,
            one.case,
            campaign.system,
            measure,
            robustness.measures[measure],
            "open",
            f"{one.failure.words}; fails with {one.survival.text} fresh noise seeds in "
            f"{result.fidelity}",
        )
        files.append(folder / f"{name}.yaml")
        write_case(folder / f"{name}.yaml", record, replace=True)
    return replace(result, files=tuple(files))


def _write_record(campaign: Campaign, results: Sequence[FamilyFound]) -> None:
    record = {
        "kind": KIND,
        "version": VERSION,
        "request": json.loads(campaign.request.identity()),
        "families": [
            {
                **family_record(result.search, result.found),
                "runs": result.runs,
                "other_runs": result.other_runs,
                "fidelity": result.fidelity,
            }
            for result in results
        ],
        "quarantined": [
            {"case": trial.case.to_json(), "reason": result.failure and result.failure.reason}
            for trial, result in campaign.progress.quarantined
        ],
    }
    path = campaign.folder / "search.json"
    with written_whole_file(path, "the search", replace=True) as part:
        part.write_text(json.dumps(record, sort_keys=True, indent=1) + "\n", encoding="utf-8")


def _write_page(campaign: Campaign, results: Sequence[FamilyFound], argv: Sequence[str]) -> Path:
    """failures.json, the episodes of the failures that count, and stress.html."""
    records, shown = [], []
    for result in results:
        episodes = shown_failures(result.found, campaign.system, result.fidelity)
        shown += list(episodes.values())
        records.append(
            search_record(
                result.search,
                result.found,
                result.files,
                result.fidelity,
                episodes,
                campaign.system,
                result.fresh_runs,
            )
        )
    record_episodes(campaign, shown, EPISODES)
    file = SearchFile(
        system=system_text(campaign.system),
        searches=tuple(records),
        command=command_text(argv),
        **quarantine_fields(campaign),
    )
    write_record(campaign.folder / "failures.json", file)
    return write_stress_page([campaign.folder], campaign.folder / "stress.html")


def _print(campaign: Campaign, results: Sequence[FamilyFound], out: Console) -> None:
    for result in results:
        search = result.search
        failed = sum(bool(e.result.failed) for e in search.evaluations)
        lost = sum(e.result.robustness is None for e in search.evaluations)
        print_line(
            f"{search.space.family.name}: {result.runs_text}; "
            f"{failed} of {count(len(search.evaluations), 'point')} "
            f"{'fails' if failed == 1 else 'fail'}, {f'{lost} without a result, ' * bool(lost)}"
            f"{count(len(search.failures), 'distinct failure')} (ended by {search.ended})",
            out,
        )
        if result.found:
            print_table(failure_table(search.space.family.name, result.found), out)
    found = [one for result in results for one in result.found]
    rendered = [one for one in found if one.full and one.full.result.robustness is not None]
    if rendered:
        confirmed = sum(one.confirmed for one in rendered)
        share = 100 * confirmed / len(rendered)
        print_line(f"confirmed in full: {confirmed} of {len(rendered)} ({share:.0f} %)", out)
    if needed := _drawn_needed(results):
        also = " ".join(f"--also {name}" for name in needed)
        held = " ".join(f"--set {name}={value}" for name, value in needed.items())
        print_line(f"drawn values: {also} lets a search vary them, {held} holds them", out)
    for result in results:
        for one, path in zip(result.found, result.files, strict=True):
            if one.counts:
                command = failure_command(one, path, campaign.system, result.fidelity)
                print_command(f"replay: {command}", out)
    print_line(f"search: {campaign.folder / 'search.json'}", out)


def _drawn_needed(results: Sequence[FamilyFound]) -> dict[str, str]:
    """The drawn values that failures are known to need: name -> nominal value."""
    needed: dict[str, str] = {}
    for search in (result.search for result in results):
        nominal = drawn_space(search.space).nominal()
        for failure in search.failures:
            if failure.narrowed:
                names = (name for name, _ in failure.signature.drawn)
                needed |= {name: value_text(nominal[name], "") for name in names}
    return needed
