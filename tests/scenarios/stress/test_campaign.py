"""Campaigns: faults of a request, and an identity that changes with whatever decides results."""

import os
import signal
from contextlib import suppress
from dataclasses import replace

import pytest

from pjpdaf.errors import BenchError
from scenarios.console.interrupts import Interrupted
from scenarios.play.fast_trust import LEAST_EPISODES, FastTrust
from scenarios.stress import campaign as module
from scenarios.stress.campaign import (
    Campaign,
    CampaignRequest,
    _say_fidelities,
    default_folder,
    families_of,
    fast_fault,
    fidelity_of,
    open_campaign,
    spaces_of,
)
from scenarios.stress.case import Case, Trial
from scenarios.stress.families import FAMILIES

CROSS = CampaignRequest("search", "cross")


def test_families_by_name_and_all():
    assert [f.name for f in families_of("drink, cross")] == ["drink", "cross"]
    assert [f.name for f in families_of("all")] == list(FAMILIES)


def test_options_go_to_the_families_that_have_the_parameter():
    request = CampaignRequest(
        "search",
        "cross,drink",
        settings=("front=left", "tracker.gate=4"),
        ranges=("speed=0.45..0.5",),
        also=("fps",),
    )
    cross, drink = spaces_of(request)
    assert cross.fixed == {"front": "left"}
    assert drink.fixed == {}
    assert (cross.axis("speed").low, drink.axis("speed").high) == (0.45, 0.5)
    assert "fps" in cross.names
    assert "fps" in drink.names
    assert request.system.tracker_settings == {"gate": "4"}


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"target": "croos"}, "no family 'croos' to stress; did you mean cross?"),
        ({"target": "cross,cross"}, "cross: named twice"),
        ({"settings": ("speeed=1",)}, "cross has no parameter 'speeed' to vary; did you mean sp"),
        ({"ranges": ("speed=0.4..0.2",)}, "speed: range is reversed: 0.4 is greater than 0.2"),
        ({"ranges": ("speed=1..2 px",)}, "--range speed: must be in m/s"),
        ({"ranges": ("speed=0.2..0.3", "speed=0.3..0.4")}, "--range speed: given twice"),
        ({"ranges": ("speed",)}, "--range speed: must be NAME=LOW..HIGH"),
        ({"target": "all,cross"}, "all: has every family in it; name no other beside it"),
        ({"settings": ("speed=0.3",), "ranges": ("speed=0.2..0.4",)}, "speed: --set holds it"),
        ({"settings": ("fps=5",), "also": ("fps",)}, "fps: --set holds it, so that it cannot vary"),
        ({"also": ("frontt",)}, "did you mean front?"),
        ({"time_limit_s": 0.0}, "--time-limit must be above 0 s"),
        ({"seed": -1}, "--seed must be between 0"),
        ({"tracker": "thesus"}, "thesus"),
        ({"settings": ("tracker.gaet=4",), "tracker": "thesis"}, "gate"),
        ({"detector": "m:f", "fidelity": "fast"}, "--fidelity fast: knows no error model"),
    ],
)
def test_a_fault_is_a_line_before_anything_is_played(changes, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BenchError) as fault, open_campaign(replace(CROSS, **changes)):
        pass
    assert line in str(fault.value)
    assert "\n" not in str(fault.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("trials", [0, 1])
def test_an_interrupt_that_a_library_swallows_still_ends_the_campaign(trials, tmp_path):
    """As pydantic does, where it comes while a digest is written."""
    request = replace(CROSS, out=tmp_path / "a", jobs=1)
    trial = Trial(Case("cross", {"frames": 4}, 1), request.system, "fast")

    def campaign():
        with open_campaign(request) as campaign:
            with suppress(KeyboardInterrupt):
                os.kill(os.getpid(), signal.SIGINT)
            for _ in range(trials):
                campaign.runner.run([trial])
                raise AssertionError("it went on")

    with pytest.raises(Interrupted, match="finished runs are kept"):
        campaign()


def test_a_detector_of_the_users_is_played_in_full():
    assert fidelity_of(CROSS) == "fast"
    assert fidelity_of(replace(CROSS, detector="mine:make")) == "full"


def test_the_folder_is_that_of_the_command(tmp_path, monkeypatch):
    def folder(request):
        return default_folder(request, request.identity())

    same = replace(CROSS, jobs=3, time_limit_s=5.0)
    assert folder(CROSS) == folder(same)
    assert folder(CROSS).name.startswith("stress-cross-search-")
    others = [
        replace(CROSS, seed=1),
        replace(CROSS, options={"budget": 7}),
        replace(CROSS, tracker="thesis"),
        replace(CROSS, settings=("speed=0.3",)),
    ]
    assert len({folder(request) for request in (CROSS, *others)}) == 5
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "my_own_tracker.py").write_text("make = None\n")
    mine = replace(CROSS, tracker="my_own_tracker:make")
    before = folder(mine)
    (tmp_path / "my_own_tracker.py").write_text("make = 1\n")
    assert folder(mine) != before


def test_what_fast_does_not_know_is_searched_in_full_unless_asked_for():
    for fidelity, expected in ((None, ["fast", "full"]), ("fast", ["fast", "fast"])):
        request = CampaignRequest("search", "cross,nuisances", fidelity=fidelity)
        campaign = Campaign(
            request, spaces_of(request), request.system, None, fidelity_of(request), *[None] * 3
        )
        assert [campaign.fidelity_for(space) for space in campaign.spaces] == expected


def test_a_family_that_fast_does_not_predict_is_played_in_full_and_the_reason_is_printed(capsys):
    request = CampaignRequest("search", "cross,nuisances", detector="default", tracker="default")
    cross, nuisances = spaces_of(request)
    assert fast_fault(request, cross) is None
    assert fast_fault(request, nuisances) == "fast does not know what varies"
    _say_fidelities(request, (cross, nuisances), "fast")
    assert capsys.readouterr().err.startswith("nuisances: played in full: fast does not")
    _say_fidelities(replace(request, fidelity="fast"), (cross, nuisances), "fast")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("trust", "fault"),
    [
        (FastTrust(25, 20, 3, 2), None),
        (FastTrust(25, 19, 4, 2), "fast agreed with rendered pictures in 19 of 25 episodes"),
        (FastTrust(LEAST_EPISODES - 1, 5, 0, 0), "fast agreed with rendered pictures in 5 of 5"),
        (None, None),  # never measured: nothing speaks against it
    ],
)
def test_a_family_whose_measured_agreement_is_low_is_played_in_full(
    trust, fault, monkeypatch, capsys
):
    measured = {} if trust is None else {"drink": trust}
    monkeypatch.setattr(module, "fast_trust", {"default": measured}.__getitem__)
    request = CampaignRequest("search", "cross,drink", detector="default", tracker="default")
    cross, drink = spaces_of(request)
    campaign = Campaign(request, (cross, drink), request.system, None, "fast", *[None] * 3)
    assert fast_fault(request, cross) is None
    assert campaign.fidelity_for(cross) == "fast"
    _say_fidelities(request, (cross, drink), "fast")
    line = capsys.readouterr().err
    if fault is None:
        assert fast_fault(request, drink) is None
        assert campaign.fidelity_for(drink) == "fast"
        assert line == ""
    else:
        assert (fast_fault(request, drink) or "").startswith(fault)
        assert campaign.fidelity_for(drink) == "full"
        assert line.startswith(f"drink: played in full: {fault}")
        assert "--fidelity fast plays it fast" in line
