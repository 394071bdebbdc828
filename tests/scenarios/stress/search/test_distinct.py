"""What a failure needs: parameters of the family, else what was drawn."""

import pytest

from reports.score.robustness import Robustness
from scenarios.spec.draw import concrete
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.confirm import MOST_RUNS
from scenarios.stress.families import find_family
from scenarios.stress.search.distinct import Signature, attribute, explained
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.search.search import SearchPlan, search_family
from scenarios.stress.space import Space

BOUNCE = Space.of(find_family("bounce"))
SCENARIO = BOUNCE.family.scenario


def drawn(case):
    return concrete(SCENARIO, case.seed, case.values)


def of_rho(case, rho):
    near = (0.1, 1.0, 1.0)
    return Evaluation(
        case, TrialResult(str(case), Robustness(rho, 1.0, 1.0, (1.0,) * 3, near, (-1,) * 6))
    )


def bearded(case):
    """Fails with a beard, whatever the family's parameters are."""
    return of_rho(case, -1.0 if drawn(case)["beard"] == "yes" else 1.0)


def tall_and_bearded(case):
    values = drawn(case)
    return of_rho(case, -1.0 if values["beard"] == "yes" and values["stature"] > 1.74 else 1.0)


def attributed(fails, case, space=BOUNCE, most=1000):
    """The failure, and the cases that were played to narrow it down, at most so many."""
    played = []

    def evaluate(changed):
        if len(played) >= most:
            return None
        played.append(changed)
        return fails(changed).failures(("swap",))

    return attribute(space, fails(case), "swap", evaluate), played


def seed_where(fails, values):
    """The first seed with which a case fails."""
    return next(s for s in range(1000) if fails(Case("bounce", values, s)).failures(("swap",)))


@pytest.mark.parametrize("point", ["nominal", "corner"])
def test_a_drawn_cause_is_named_where_no_parameter_matters(point):
    unit = [0.9] * len(BOUNCE.axes)
    values = BOUNCE.nominal() if point == "nominal" else BOUNCE.values_of_unit(unit)
    case = Case("bounce", values, seed_where(bearded, values))
    failure, played = attributed(bearded, case)
    assert failure.signature == Signature("bounce", "swap", (), (("beard", "yes"),))
    assert failure.words == "drawn: beard yes"
    assert len(played) <= 14  # one for the family's, about 2 log2(36) for the drawn
    nominal = Space.of(BOUNCE.family, also=tuple(SCENARIO.parameters)).nominal()
    assert failure.minimal.values == {**nominal, "beard": "yes"}
    assert failure.minimal.seed == case.seed


def test_two_drawn_causes_are_named_with_their_thirds():
    values = BOUNCE.nominal()
    case = Case("bounce", values, seed_where(tall_and_bearded, values))
    failure, _ = attributed(tall_and_bearded, case)
    assert failure.words == "drawn: stature high, beard yes"


def test_no_run_is_spent_on_drawn_values_where_a_parameter_matters():
    def fails(case):
        return of_rho(case, 0.3 - float(case.values["speed"]))

    case = Case("bounce", BOUNCE.values_of_unit([0.9] * len(BOUNCE.axes)), 1)
    failure, played = attributed(fails, case)
    assert (failure.words, failure.signature.drawn) == ("speed high", ())
    assert all(set(other.values) == set(case.values) for other in played)


def test_what_fails_with_all_drawn_values_nominal_says_so():
    case = Case("bounce", BOUNCE.nominal(), 1)
    failure, played = attributed(lambda case: of_rho(case, -1.0), case)
    assert failure.words == "nominal, drawn values too"
    assert len(played) == 1
    assert drawn(failure.minimal)["stature"] == 1.71


def test_a_value_that_is_set_is_not_drawn():
    space = Space.of(BOUNCE.family, fixed={"beard": "yes"})
    failure, _ = attributed(bearded, Case("bounce", space.nominal(), 1), space)
    assert failure.words == "nominal, drawn values too"
    assert failure.minimal.values["beard"] == "yes"


@pytest.mark.parametrize("most", [0, 1, 5])
def test_where_the_budget_ends_among_drawn_values_the_failure_says_so(most):
    values = BOUNCE.values_of_unit([0.9] * len(BOUNCE.axes))
    case = Case("bounce", values, seed_where(bearded, values))
    failure, played = attributed(bearded, case, most=most)
    assert not failure.narrowed
    assert len(played) == most
    assert failure.words.endswith("(budget spent: perhaps less)")
    assert failure.words.startswith("drawn: any of ") == (most > 0)
    assert ("beard", "yes") in failure.signature.drawn or most == 0


def test_a_failure_with_the_same_drawn_value_is_explained_by_it():
    values = BOUNCE.values_of_unit([0.3] * len(BOUNCE.axes))
    known = [Signature("bounce", "swap", (), (("beard", "yes"),))]
    with_beard = Case("bounce", values, seed_where(bearded, values))
    without = next(
        case
        for case in (Case("bounce", values, seed) for seed in range(100))
        if drawn(case)["beard"] == "no"
    )
    assert explained(known, BOUNCE, with_beard, "swap")
    assert not explained(known, BOUNCE, without, "swap")
    assert not explained(known, BOUNCE, with_beard, "lost_left")
    nominal = Signature("bounce", "swap", ())
    assert not explained([nominal], BOUNCE, with_beard, "swap")


@pytest.mark.parametrize(
    ("one", "other", "covers"),
    [
        ((("beard", "yes"),), (("stature", "high"), ("beard", "yes")), True),
        ((("stature", "high"), ("beard", "yes")), (("beard", "yes"),), False),
        ((("beard", "yes"),), (("stature", "high"),), False),
        ((), (("beard", "yes"),), False),
    ],
)
def test_a_signature_covers_those_that_need_more_drawn_values(one, other, covers):
    first, second = (Signature("bounce", "swap", (), cell) for cell in (one, other))
    assert first.covers(second) is covers


def searched(fails, budget, seed=2):
    played = []

    def evaluate(cases):
        played.extend(cases)
        return [fails(case) for case in cases]

    plan = SearchPlan(budget=budget, goals=("swap",), seed=seed, fresh=MOST_RUNS)
    return search_family(BOUNCE, evaluate, plan), played


def test_a_search_names_a_drawn_cause_once_and_spends_no_more_on_it():
    result, played = searched(bearded, 200)
    assert [failure.words for failure in result.failures] == ["drawn: beard yes"]
    assert sum(bool(e.result.failed) for e in result.evaluations) >= 15
    assert result.runs == len(played) <= 200 - MOST_RUNS
    assert result.runs - len(result.evaluations) <= 14


def test_a_row_gives_way_to_one_that_covers_it():
    """The first person to fail is no taller than will do for those whose head is small."""

    def fails(case):
        values = drawn(case)
        tall = values["stature"] > (1.737 if values["head_scale"] < 0.99 else 1.78)
        return of_rho(case, -1.0 if values["beard"] == "yes" and tall else 1.0)

    first, _ = searched(fails, 80)
    whole, _ = searched(fails, 150)
    assert [f.words for f in first.failures] == ["drawn: stature high, head_scale low, beard yes"]
    assert [f.words for f in whole.failures] == ["drawn: stature high, beard yes"]


@pytest.mark.parametrize("budget", [18, 22, 30, 45])
def test_drawn_values_are_paid_by_the_budget(budget):
    result, played = searched(bearded, budget)
    assert result.runs == len(played) <= budget
    assert len({str(case) for case in played}) == len(played)
