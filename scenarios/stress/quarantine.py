"""Trials without a result: a plug-in raised, hung or killed its worker. Named, and left out."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from pjpdaf.errors import InfrastructureError
from reports.summary.text import count
from scenarios.console.lines import print_line
from scenarios.stress.campaign import Campaign
from scenarios.stress.case import TrialResult
from scenarios.stress.system_text import replay_command


def quarantine_fields(campaign: Campaign) -> dict[str, Any]:
    """Of the file that the page reads: how many trials gave no result, and why the first did."""
    quarantined = campaign.progress.quarantined
    if not quarantined:
        return {}
    trial, result = quarantined[0]
    first = f"{trial.case.family}: {_reason(result)}"
    return {"without_result": len(quarantined), "first_fault": first}


def name_quarantined(campaign: Campaign, out: Console) -> None:
    """Print how many trials gave no result and the first of them; nothing where all did.

    Raises InfrastructureError where none did: figures without a result say nothing.
    """
    quarantined = campaign.progress.quarantined
    if quarantined:
        trial, result = quarantined[0]
        print_line(
            f"no result in {count(len(quarantined), 'run')}, left out of all figures; the first: "
            f"{_reason(result)}: {replay_command(trial)}",
            out,
        )
    if not campaign.progress.results:
        raise InfrastructureError("no run gave a result")


def _reason(result: TrialResult) -> str:
    assert result.failure is not None
    return f"{result.failure.kind}: {result.failure.reason}"
