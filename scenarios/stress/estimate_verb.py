"""The verb `estimate`: the probability of each kind of failure, family by family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from reports.score.robustness import Goal, measures_of
from reports.stress.page import write_stress_page
from reports.stress.records import EstimateFile, EstimateRecord, write_record
from reports.stress.words import GOAL_SHORT, interval_text, share_text
from reports.summary.plain_table import plain_table
from scenarios.console.lines import print_line
from scenarios.console.tables import print_table
from scenarios.spec.suggestion import suggestion
from scenarios.stress.campaign import Campaign, CampaignRequest, open_campaign
from scenarios.stress.case import Case, Fidelity, Trial, TrialResult
from scenarios.stress.estimate.correction import FullRuns, allocation, corrected
from scenarios.stress.estimate.estimate import METHODS, MethodChoice, Sample, estimate
from scenarios.stress.estimate.full_sample import failing_draws, passing_draws
from scenarios.stress.estimate.outcomes import Outcomes
from scenarios.stress.estimate.probability import LEAST_ESS, MOST_WEIGHT, Probability
from scenarios.stress.quarantine import name_quarantined, quarantine_fields
from scenarios.stress.search_verb import goals_of
from scenarios.stress.space import Space
from scenarios.stress.system_text import command_text, system_text

MOST_RUNS = 1_000_000
INCONCLUSIVE = 3  # exit code
_NO_RESULT = 3.0  # objective of a draw that gave no result


@dataclass(frozen=True)
class EstimateRequest:
    """The options of `estimate`. goals: `all`, or some of swap, head, lost with commas between.

    runs: of a family and goal, adaptation included; full: rendered runs that correct each figure;
    method: of `METHODS`.
    """

    campaign: CampaignRequest
    goals: str = "swap,lost"
    runs: int = 500
    full: int = 20
    method: str = "auto"
    argv: tuple[str, ...] = ()


def estimate_verb(request: EstimateRequest) -> int:
    """Estimate, print the table, write estimate.json and the page; 3 where one is inconclusive.

    Raises BenchError, and Interrupted after a signal: the same command goes on.
    """
    goals = goals_of(request.goals)
    method = _method(request.method)
    if not 24 <= request.runs <= MOST_RUNS:
        raise BenchError(f"--runs must be between 24 and {MOST_RUNS}, got {request.runs}")
    if not 0 <= request.full <= request.runs:
        raise BenchError(f"--full must be between 0 and --runs, got {request.full}")
    options = {"goals": goals, "runs": request.runs, "full": request.full, "method": method}
    with open_campaign(replace(request.campaign, options=options)) as campaign:
        records = [
            _estimate(campaign, space, goal, request, method)
            for space in campaign.spaces
            for goal in goals
        ]
        file = EstimateFile(
            system=system_text(campaign.system),
            estimates=tuple(records),
            **quarantine_fields(campaign),
        )
        write_record(campaign.folder / "estimate.json", file)
        page = write_stress_page([campaign.folder], campaign.folder / "stress.html")
    out = Console()
    print_table(_table(records), out)
    for line in _reservations(records):
        print_line(line, out)
    print_line(f"page: {page}", out)
    name_quarantined(campaign, out)
    return INCONCLUSIVE if any(r.verdict == "inconclusive" for r in records) else 0


def _method(text: str) -> MethodChoice:
    for method in METHODS:
        if text == method:
            return method
    raise BenchError(f"--method {text[:60]}: unknown{suggestion(text, METHODS)}")


def _estimate(
    campaign: Campaign, space: Space, goal: Goal, request: EstimateRequest, method: MethodChoice
) -> EstimateRecord:
    name, seed = space.family.name, campaign.request.seed
    fidelity = campaign.fidelity_for(space)
    campaign.progress.start(f"{name}: {GOAL_SHORT[goal]}", request.runs)

    def play(latents: Floats, seeds: NDArray[np.int64]) -> Outcomes:
        cases = _cases(space, latents, seeds)
        return outcomes_of(_run(campaign, cases, fidelity), goal)

    probability, sample = estimate(
        play, len(space.axes), request.runs, seed, method, stream=f"{name}/"
    )
    record = _record(campaign, space, goal, probability, request)
    if fidelity == "full" or request.full == 0:
        return record
    return _corrected(campaign, space, goal, request.full, probability, sample, record)


def _corrected(
    campaign: Campaign,
    space: Space,
    goal: Goal,
    full_runs: int,
    fast: Probability,
    sample: Sample,
    record: EstimateRecord,
) -> EstimateRecord:
    """The record of a figure about pictures, by full runs of draws that fast failed and passed."""
    failing, passing = allocation(fast, full_runs)
    campaign.progress.start(f"{space.family.name}: {GOAL_SHORT[goal]} in full", full_runs)
    chosen = (
        failing_draws(sample, failing, campaign.request.seed),
        passing_draws(sample, passing),
    )
    played = []
    for positions in chosen:
        cases = _cases(space, sample.latents[positions], sample.seeds[positions])
        outcomes = outcomes_of(_run(campaign, cases, "full"), goal)
        failed = outcomes.failed & outcomes.counted
        played.append(FullRuns(int(outcomes.counted.sum()), int(failed.sum())))
    result = corrected(fast, played[0], played[1], campaign.request.seed)
    verdict = record.verdict
    if not result.conclusive:
        verdict = "inconclusive"
    elif result.p > 0:
        verdict = "estimated"
    return record.model_copy(
        update={
            "fidelity": "full",
            "p": result.p,
            "low": result.low,
            "high": result.high,
            "verdict": verdict,
            "fast": (fast.p, fast.low, fast.high),
            "full_failing": (played[0].failures, played[0].runs),
            "full_passing": (played[1].failures, played[1].runs),
        }
    )


def outcomes_of(results: Sequence[TrialResult], goal: Goal) -> Outcomes:
    """The outcomes of trials for a goal; a trial without a result counts as none."""
    names = measures_of((goal,))
    return Outcomes(
        np.array([any(name in names for name in r.failed) for r in results], dtype=bool),
        np.array(
            [_NO_RESULT if r.robustness is None else r.robustness.objective(goal) for r in results]
        ),
        np.array([r.robustness is not None for r in results], dtype=bool),
    )


def _cases(space: Space, latents: Floats, seeds: NDArray[np.int64]) -> list[Case]:
    target = space.family.target
    return [
        Case(target, space.values_of_latent(z), int(s)) for z, s in zip(latents, seeds, strict=True)
    ]


def _run(campaign: Campaign, cases: Sequence[Case], fidelity: Fidelity) -> list[TrialResult]:
    return campaign.runner.run([Trial(case, campaign.system, fidelity) for case in cases])


def _record(
    campaign: Campaign,
    space: Space,
    goal: Goal,
    probability: Probability,
    request: EstimateRequest,
) -> EstimateRecord:
    return EstimateRecord(
        family=space.family.name,
        goal=goal,
        fidelity=campaign.fidelity_for(space),
        p=probability.p,
        low=probability.low,
        high=probability.high,
        method=probability.method,
        verdict=probability.verdict,
        runs=probability.runs,
        adaptation_runs=probability.adaptation_runs,
        failures=probability.failures,
        ess=probability.ess,
        largest_weight=probability.largest_weight,
        command=command_text(request.argv),
    )


def _table(records: Sequence[EstimateRecord]) -> Table:
    table = plain_table()
    for heading in ("family", "of", "95 % interval"):
        table.add_column(heading, no_wrap=True)
    for heading in ("runs", "failed", "in full: of fast\nfailed, passed"):
        table.add_column(heading, justify="right", no_wrap=True)
    for r in records:
        pairs = (r.full_failing, r.full_passing)
        table.add_row(
            r.family,
            r.goal,
            interval_text(r.p, r.low, r.high),
            str(r.runs),
            str(r.failures),
            ", ".join("-" if pair is None else f"{pair[0]}/{pair[1]}" for pair in pairs),
        )
    return table


def _reservations(records: Sequence[EstimateRecord]) -> list[str]:
    """A line for each inconclusive estimate."""
    return [
        f"inconclusive: {r.family} {GOAL_SHORT[r.goal]}: {r.ess:.0f} effective failures, largest "
        f"weight {share_text(r.largest_weight)}; {_decides(r)}"
        for r in records
        if r.verdict == "inconclusive"
    ]


def _decides(r: EstimateRecord) -> str:
    """What would decide an inconclusive estimate: effective failures grow with the runs."""
    too_few, weighted = r.ess < LEAST_ESS, r.largest_weight > MOST_WEIGHT
    if r.method == "plain" or not (too_few or weighted):
        return "more --full would decide it"
    if r.ess < 1.0:
        return f"too few to say how many more --runs than {r.runs + r.adaptation_runs} it needs"
    times = max(LEAST_ESS / r.ess, r.largest_weight / MOST_WEIGHT)
    return f"--runs {_up((r.runs + r.adaptation_runs) * times)} may decide it"


def _up(number: float) -> int:
    """Round up to two digits."""
    step = 10 ** max(len(str(int(number))) - 2, 0)
    return int(-(-number // step) * step)
