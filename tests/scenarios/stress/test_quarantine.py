"""Trials without a result are named by every verb, and figures without any result are refused."""

import pytest
from rich.console import Console

from pjpdaf.errors import InfrastructureError
from reports.score.robustness import Robustness
from scenarios.console.progress import Meter
from scenarios.play.job import System
from scenarios.stress.campaign import Campaign, CampaignRequest
from scenarios.stress.case import Case, Trial, TrialFailure, TrialResult
from scenarios.stress.progress import Progress
from scenarios.stress.quarantine import name_quarantined, quarantine_fields

SYSTEM = System("thesis", "mine:make")


def campaign_of(*results: TrialResult) -> Campaign:
    progress = Progress(Meter())
    for result in results:
        trial = Trial(Case("drink", {"speed": 0.5}, int(result.key)), SYSTEM, "fast")
        progress.on_result(trial, result)
    request = CampaignRequest("map", "drink")
    return Campaign(request, (), SYSTEM, None, "fast", None, None, progress)


def good(key: str) -> TrialResult:
    return TrialResult(key, Robustness(0.5, 1.0, 1.0, (1.0,) * 3, (0.1,) * 3, (-1,) * 6))


def lost(key: str, kind: str = "plug-in") -> TrialResult:
    return TrialResult(key, None, failure=TrialFailure(kind, "no step today"))


def test_the_first_is_named_with_the_command_that_plays_it(capsys):
    name_quarantined(campaign_of(good("1"), lost("2"), lost("3", "unposable")), Console(width=999))
    assert capsys.readouterr().out == (
        "no result in 1 run, left out of all figures; the first: plug-in: no step today: "
        "pjpdaf-bench stress drink replay --seed 2 --tracker mine:make --detector thesis "
        "--fidelity fast --set speed=0.5\n"
    )


def test_the_page_is_told_how_many_and_why():
    fields = quarantine_fields(campaign_of(good("1"), lost("2"), lost("4"), lost("3", "unposable")))
    assert fields == {"without_result": 2, "first_fault": "drink: plug-in: no step today"}
    assert quarantine_fields(campaign_of(good("1"), lost("3", "unposable"))) == {}


def test_nothing_is_said_where_all_gave_a_result(capsys):
    name_quarantined(campaign_of(good("1"), lost("3", "unposable")), Console())
    assert capsys.readouterr().out == ""


def test_no_result_at_all_is_a_fault(capsys):
    with pytest.raises(InfrastructureError, match="no run gave a result"):
        name_quarantined(campaign_of(lost("1"), lost("2")), Console(width=999))
    assert capsys.readouterr().out.startswith("no result in 2 runs")
