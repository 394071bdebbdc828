"""map, estimate and compare from the command line's request to their files."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from pjpdaf.errors import BenchError, InfrastructureError
from reports.stress.load import load_stress
from reports.stress.records import EstimateRecord
from scenarios.stress.campaign import CampaignRequest
from scenarios.stress.compare_verb import CompareRequest, compare_verb, difference_plan
from scenarios.stress.estimate_verb import EstimateRequest, _reservations, estimate_verb
from scenarios.stress.families import find_family
from scenarios.stress.map.explore import MapPlan, others_named
from scenarios.stress.map_verb import MapRequest, map_verb
from scenarios.stress.search_verb import goal_of


def campaign(verb: str, out: Path, target: str = "bounce", **changes: object) -> CampaignRequest:
    # Six frames show nothing of a motion, but everything of the verbs.
    short = ("frames=6",)
    request = CampaignRequest(verb, target, "thesis", "thesis", short, out=out, jobs=1)
    return dataclasses.replace(request, **changes)


def test_a_map_is_the_same_when_it_goes_on(tmp_path, capsys) -> None:
    plan = MapPlan("speed", "front", cells=2, seeds=1, refine=0)
    request = MapRequest(campaign("map", tmp_path / "a"), plan, episodes=1, argv=("stress",))
    map_verb(request)
    first = (tmp_path / "a" / "map.json").read_bytes()
    assert (
        "bounce: speed x front, 4 cells, 4 runs in fast; of the cells' 4 trials: none"
        in capsys.readouterr().out
    )
    (tmp_path / "a" / "map.json").unlink()
    map_verb(request)
    assert (tmp_path / "a" / "map.json").read_bytes() == first
    (folder,) = load_stress([tmp_path / "a"])
    assert folder.map is not None
    assert folder.episodes is not None
    (record,) = folder.map.maps
    kept = [cell.episode for cell in record.cells if cell.episode is not None]
    assert len(kept) == 1
    assert (kept[0].label, kept[0].seed) == tuple(folder.episodes.episodes.iloc[0][:2])
    # Silhouettes of every frame.
    assert folder.episodes.meta["films"][0]["whole"]
    assert "#play=0-0-" in (tmp_path / "a" / "stress.html").read_text(encoding="utf-8")


@pytest.mark.long
def test_an_estimate_and_its_correction(tmp_path, capsys) -> None:
    request = EstimateRequest(campaign("estimate", tmp_path / "a"), "swap", runs=36, full=2)
    code = estimate_verb(request)
    (folder,) = load_stress([tmp_path / "a"])
    assert folder.estimate is not None
    (record,) = folder.estimate.estimates
    assert record.fidelity == "full"
    assert record.fast is not None
    assert record.full_failing is not None
    assert record.full_passing is not None
    assert record.full_failing[1] + record.full_passing[1] == 2
    assert code == (3 if record.verdict == "inconclusive" else 0)
    assert "swap" in capsys.readouterr().out


@pytest.mark.long
def test_a_comparison_counts_every_draw(tmp_path) -> None:
    plan = difference_plan("speed", "depth_gap", 2, 1, 0, "swap")
    compared = campaign("compare", tmp_path / "a", "cross", against="default")
    compare_verb(CompareRequest(compared, "swap", runs=4, plan=plan))
    (folder,) = load_stress([tmp_path / "a"])
    assert folder.compare is not None
    (record,) = folder.compare.comparisons
    assert record.both + record.only_a + record.only_b + record.neither == 4
    assert record.map_a is not None
    assert record.map_b is not None
    draws = [[cell.case for cell in m.cells] for m in (record.map_a, record.map_b)]
    assert draws[0] == draws[1]


def test_a_comparison_without_a_pair_is_no_result(tmp_path, capsys) -> None:
    compared = campaign("compare", tmp_path / "a", against="faulty_trackers:Raises")
    with pytest.raises(InfrastructureError, match="no draw gave a result with both trackers"):
        compare_verb(CompareRequest(compared, "swap", runs=2))
    assert "no result in 2 runs, left out of all figures" in capsys.readouterr().out
    (folder,) = load_stress([tmp_path / "a"])
    assert folder.compare is not None
    assert folder.compare.without_result == 2
    page = (tmp_path / "a" / "stress.html").read_text(encoding="utf-8")
    assert "2 runs without a result, left out of all figures; the first: bounce: plug-in: " in page


@pytest.mark.parametrize(
    ("plan", "changes", "message"),
    [
        (MapPlan("speed", "speed"), {}, "--x and --y are both speed; a map needs two parameters"),
        (MapPlan("sped"), {}, "bounce has no parameter 'sped' to vary; did you mean speed?"),
        (MapPlan("speed"), {"ranges": ("speed=0.5..0.2",)}, "range is reversed: 0.5 is greater"),
        (MapPlan("speed", "hold", cells=80), {}, "a map of 80 x 80 cells is too many"),
        (MapPlan("speed", cells=0), {}, "--cells must be between 1 and 2500, got 0"),
        (MapPlan("speed", refine=5), {}, "--refine must be between 0 and 4, got 5"),
        (MapPlan("speed", level=1.0), {}, "--level must be above 0 and below 1, got 1"),
        (MapPlan("speed"), {"target": "bonce"}, "no family 'bonce' to stress; did you mean bounce"),
        (MapPlan("speed"), {"settings": ("speed=0.3", "frames=6")}, "speed: --set holds it"),
    ],
)
def test_maps_that_are_refused_before_anything_is_played(
    tmp_path, plan: MapPlan, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(BenchError) as fault:
        map_verb(MapRequest(campaign("map", tmp_path / "a", **changes), plan))
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)
    assert not (tmp_path / "a").exists()


def test_options_that_are_refused(tmp_path) -> None:
    request = campaign("estimate", tmp_path / "a")
    with pytest.raises(BenchError, match="--runs must be between 24 and 1000000, got 5"):
        estimate_verb(EstimateRequest(request, runs=5))
    with pytest.raises(BenchError, match="--full must be between 0 and --runs, got 60"):
        estimate_verb(EstimateRequest(request, runs=50, full=60))
    with pytest.raises(BenchError, match="--method plan: unknown; did you mean plain"):
        estimate_verb(EstimateRequest(request, method="plan"))
    with pytest.raises(BenchError, match="compare needs two systems, got the same twice"):
        compare_verb(CompareRequest(campaign("compare", tmp_path / "a", against="thesis")))
    with pytest.raises(BenchError, match="needs both --x and --y"):
        difference_plan("speed", None, 4, 4, 0, "swap")
    with pytest.raises(BenchError, match="--others drwn: must be drawn or medians"):
        others_named("drwn")
    with pytest.raises(BenchError, match="--find all: must be one of swap, head, lost"):
        goal_of("all")
    with pytest.raises(BenchError, match="cross,bounce: one case at a time; name one family"):
        find_family("cross,bounce")


@pytest.mark.parametrize(
    ("ess", "weight", "method", "advice"),
    [
        (40.0, 0.04, "importance", "40 effective failures, largest weight 4 %; --runs 7500 may"),
        (120.0, 0.1, "importance", "120 effective failures, largest weight 10 %; --runs 6000 may"),
        (0.0, 1.0, "importance", "too few to say how many more --runs than 3000 it needs"),
        (30.0, 0.01, "plain", "more --full would decide it"),
    ],
)
def test_an_inconclusive_estimate_says_what_may_decide_it(ess, weight, method, advice) -> None:
    record = EstimateRecord(
        family="bounce",
        goal="swap",
        fidelity="full",
        p=0.001,
        low=0.0001,
        high=0.01,
        method=method,
        verdict="inconclusive",
        runs=2000,
        adaptation_runs=1000,
        failures=10,
        ess=ess,
        largest_weight=weight,
    )
    (line,) = _reservations([record])
    assert advice in line
