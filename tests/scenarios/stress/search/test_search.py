"""The search on a made-up tracker whose failures are known exactly."""

from dataclasses import replace

import numpy as np
import pytest

from reports.score.robustness import Robustness
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.confirm import MOST_RUNS, choose
from scenarios.stress.families import find_family
from scenarios.stress.search.design import corners, sobol
from scenarios.stress.search.distinct import DistinctFailure, Signature
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.search.search import SearchPlan, search_family
from scenarios.stress.space import Space

CROSS = Space.of(find_family("cross"))
SWAPS = ("swap",)
FAILING = Case(
    "cross",
    {
        **CROSS.nominal(),
        **{n: CROSS.axis(n).of_unit(u) for n, u in (("speed", 0.85), ("depth_gap", 0.2))},
        "hold": CROSS.axis("hold").of_unit(0.8),
    },
    7,
)


def of_robustness(case, rho, coalescence_m):
    near = (float(coalescence_m), 1.0, 1.0)
    return Evaluation(
        case,
        TrialResult(str(case), Robustness(rho, 1.0, 1.0, (0.9, 0.9, 0.9), near, (-1,) * 6)),
    )


def made_up(case):
    """Fails in a cube of speed, depth and hold that no corner is in: 8e-4 of the unit cube."""
    u = dict(zip(CROSS.names, CROSS.unit_of_values(case.values), strict=True))
    far = np.abs([u["speed"] - 0.85, u["depth_gap"] - 0.2, u["hold"] - 0.8])
    rho = -1.0 if far.max() < 0.0465 else 1.0
    return of_robustness(case, rho, 0.02 + 0.2 * np.linalg.norm(far))


def search(plan, evaluate=made_up):
    return search_family(CROSS, lambda cases: [evaluate(case) for case in cases], plan)


def test_corners_show_every_pair_of_ends():
    points = corners(13)
    assert points.shape == (16, 13)
    assert (points.mean(axis=0) == 0.5).all()
    for a in range(13):
        for b in range(a):
            assert len({*map(tuple, points[:, [a, b]])}) == 4


def test_sobol_is_the_same_again_and_other_for_another_seed():
    first = np.array([next(iter(sobol(5, seed, "x"))) for seed in (0, 0, 1)])
    assert (first[0] == first[1]).all()
    assert (first[0] != first[2]).any()


def test_it_finds_what_is_too_rare_for_chance():
    """A failure of 1 in 1200 in each of six campaigns of 300 runs; chance needs 800 on average."""
    found = [
        search(SearchPlan(budget=300, goals=SWAPS, seed=seed, distinct=1)).first_failure()
        for seed in range(6)
    ]
    assert None not in found
    assert np.median(found) < 200


def test_distinct_failures_name_the_parameters_that_matter():
    result = search(SearchPlan(budget=400, goals=SWAPS, seed=1))
    (failure,) = result.failures
    assert dict(failure.signature.cell) == {"speed": "high", "depth_gap": "low", "hold": "high"}
    nominal = CROSS.nominal()
    changed = {n for n, v in failure.minimal.values.items() if v != nominal[n]}
    assert changed == {"speed", "depth_gap", "hold"}


def test_same_plan_same_search_and_other_seed_another():
    plan = SearchPlan(budget=150, goals=SWAPS, seed=3)
    first, second = search(plan), search(plan)
    assert [e.case for e in first.evaluations] == [e.case for e in second.evaluations]
    assert search(replace(plan, seed=4)).evaluations[40].case != first.evaluations[40].case


def test_the_budget_is_kept_and_every_end_has_its_reason():
    ended = search(SearchPlan(budget=100, goals=SWAPS), safe)
    assert (ended.ended, ended.runs, len(ended.evaluations)) == ("budget", 100, 100)
    ended = search(SearchPlan(budget=5000, goals=SWAPS, patience=150), safe)
    assert ended.ended == "patience"


def safe(case):
    return of_robustness(case, 1.0, 0.9)


@pytest.mark.parametrize("budget", [17, 20, 40, 77, 150])
def test_what_narrows_failures_down_is_paid_by_the_budget(budget):
    """Every run is counted, and no more are spent, wherever the budget ends."""
    played = []

    def evaluate(cases):
        played.extend(str(case) for case in cases)
        return [of_robustness(case, 0.4 - float(case.values["speed"]), 0.1) for case in cases]

    plan = SearchPlan(budget=budget, goals=SWAPS, seed=1, fresh=MOST_RUNS)
    result = search_family(CROSS, evaluate, plan)
    assert result.failures
    assert result.runs == len(played) <= budget
    assert len(set(played)) == len(played)
    left = budget - result.runs
    for number, failure in enumerate(result.failures):
        chosen = choose(failure, evaluate, 1, number, min(left, MOST_RUNS))
        assert chosen.survival.of <= 4
        left -= chosen.runs
    assert len(played) <= budget
    assert left == budget - len(played)


def test_a_failure_that_the_budget_leaves_unexplained_says_so():
    def fails(case):
        return of_robustness(case, 0.4 - float(case.values["speed"]), 0.1)

    plan = SearchPlan(budget=26, goals=SWAPS, seed=1, fresh=MOST_RUNS)
    (failure,) = search(plan, fails).failures
    assert not failure.narrowed
    assert failure.words.endswith("(budget spent: perhaps less)")
    (failure,) = search(replace(plan, budget=60), fails).failures
    assert failure.words == "speed high"


@pytest.mark.parametrize(
    ("count", "words"), [(4, "p0 low, p1 low, p2 low, p3 low"), (5, "any of 5")]
)
def test_few_candidates_are_named_and_many_counted(count, words):
    case = Case("cross", CROSS.nominal(), 1)
    signature = Signature("cross", "swap", tuple((f"p{i}", "low") for i in range(count)))
    unsure = DistinctFailure(signature, of_robustness(case, -1.0, 0.1), case, narrowed=False)
    assert unsure.words == f"{words} (budget spent: perhaps less)"
    assert replace(unsure, narrowed=True).words == signature.words


def test_known_cases_come_first():
    known = FAILING
    other = replace(known, family="bounce")
    result = search(SearchPlan(budget=60, goals=SWAPS, known=(other, known), distinct=1))
    assert result.first_failure() == 1
    assert result.evaluations[0].case == known


def test_against_another_tracker_only_differences_count():
    def both(case):
        evaluation = made_up(case)
        front = case.values["front"] == "right"
        other = evaluation.result if front else safe(case).result
        return replace(evaluation, other=other)

    assert both(FAILING).failures(SWAPS) == ()
    assert both(FAILING).objective("swap") == 3.0
    assert both(FAILING.with_values({"front": "left"})).failures(SWAPS) == ("swap",)
    result = search(SearchPlan(budget=500, goals=SWAPS, seed=1), both)
    assert [dict(f.signature.cell).get("front") for f in result.failures] == ["left"]


def test_a_trial_without_a_result_stops_nothing():
    def faulty(case):
        if case.values["back"] == "no":
            return Evaluation(case, TrialResult("k", None))
        return made_up(case)

    result = search(SearchPlan(budget=400, goals=SWAPS, seed=1), faulty)
    assert result.failures
    assert result.runs <= 400


@pytest.mark.parametrize("fps", [None, (1.0, 3.0)])
def test_further_parameters_are_searched(fps):
    space = Space.of(find_family("cross"), ranges={"fps": fps} if fps else {})
    seen = search_family(
        space, lambda cases: [safe(case) for case in cases], SearchPlan(budget=40)
    ).evaluations
    assert ("fps" in seen[-1].case.values) == bool(fps)


def test_a_family_that_has_nothing_to_vary_is_played_with_other_noise_only():
    """There is no dimension to descend in; every third noise seed fails."""
    still = Space(CROSS.family, (), CROSS.nominal())

    def evaluate(cases):
        return [of_robustness(case, -1.0 if case.seed % 3 == 0 else 1.0, 0.2) for case in cases]

    found = search_family(still, evaluate, SearchPlan(budget=120, goals=SWAPS, seed=0))
    assert (found.ended, len(found.failures)) == ("budget", 1)
    assert found.failures[0].words == "nominal, drawn values too"
    seeds = {evaluation.case.seed for evaluation in found.evaluations}
    assert len(seeds) == len(found.evaluations) >= 100
