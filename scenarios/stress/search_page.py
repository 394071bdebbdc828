"""The page of a search: its failures as records, their episodes played again with a film."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from reports.stress.page import write_stress_page
from reports.stress.records import (
    ChangedValue,
    FailureRecord,
    SearchFile,
    SearchRecord,
    write_record,
)
from scenarios.spec.parameters.numeric import Numeric
from scenarios.stress.campaign import Campaign
from scenarios.stress.case import Trial
from scenarios.stress.confirm import Counterexample
from scenarios.stress.map.record import case_record
from scenarios.stress.recording import Shown, record_episodes
from scenarios.stress.search.search import FamilySearch
from scenarios.stress.space import Space
from scenarios.stress.system_text import command_text, replay_command, system_text

FamilyPart = tuple[FamilySearch, Sequence[Counterexample], Sequence[Path | None]]


def write_search_page(
    campaign: Campaign, parts: Sequence[FamilyPart], most: int, argv: Sequence[str]
) -> Path:
    """Write failures.json, the episodes and stress.html; the path of the page.

    most: episodes of each family that are played again, confirmed ones, which are rendered, first.
    """
    shown: list[Shown] = []
    records = []
    for search, found, files in parts:
        trials = _shown(campaign, found, most)
        shown += trials.values()
        failures = tuple(
            _failure(campaign, search.space, one, file, trials.get(n))
            for n, (one, file) in enumerate(zip(found, files, strict=True))
        )
        records.append(
            SearchRecord(
                family=search.space.family.name,
                fidelity=campaign.fidelity,
                parameters=len(search.space.axes),
                runs=search.runs,
                failing=sum(bool(e.result.failed) for e in search.evaluations),
                first=search.first_failure(),
                ended=search.ended,
                failures=failures,
            )
        )
    if shown:
        campaign.progress.start("episodes of the page", len(shown))
        record_episodes(
            campaign.folder,
            shown,
            campaign.runner.executor,
            campaign.request.time_limit_s,
            lambda: campaign.progress.bar.advance(campaign.progress.task),
        )
    system = system_text(campaign.system)
    if campaign.other is not None:
        system += f" against {system_text(campaign.other)}"
    file = SearchFile(system=system, searches=tuple(records), command=command_text(argv))
    write_record(campaign.folder / "failures.json", file)
    return write_stress_page([campaign.folder], campaign.folder / "stress.html")


def _shown(campaign: Campaign, found: Sequence[Counterexample], most: int) -> dict[int, Shown]:
    """The trials to play again, by the number of their failure."""
    order = sorted(range(len(found)), key=lambda n: (not found[n].confirmed, n))[:most]
    return {
        n: Shown(
            f"{found[n].case.family}: failure {n + 1}",
            Trial(
                found[n].case, campaign.system, "full" if found[n].confirmed else campaign.fidelity
            ),
        )
        for n in sorted(order)
    }


def _failure(
    campaign: Campaign, space: Space, one: Counterexample, file: Path | None, shown: Shown | None
) -> FailureRecord:
    nominal, values = space.nominal(), one.case.values
    robustness = one.result.robustness
    changed = []
    for name, _ in one.failure.signature.cell:
        parameter = space.axis(name).parameter
        unit = parameter.unit if isinstance(parameter, Numeric) else ""
        changed.append(
            ChangedValue(name=name, unit=unit, value=values[name], nominal=nominal[name])
        )
    return FailureRecord(
        measure=one.measure,
        cell=one.failure.signature.words,
        case=case_record(one.case),
        changed=tuple(changed),
        fidelity=campaign.fidelity,
        rho=robustness.measures[one.measure] if robustness is not None else 0.0,
        severity=one.result.severity,
        confirmed=None if one.full is None else one.confirmed,
        survived=(one.survival.failed, one.survival.of),
        blame=one.blame,
        command=replay_command(one.case, campaign.system)
        if file is None
        else shlex.join(["pjpdaf-bench", "stress", str(file), "replay"]),
        episode=None if shown is None else shown.key,
    )
