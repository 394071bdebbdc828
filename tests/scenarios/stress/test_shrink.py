"""Shrinking of a made-up failure that depends on noise."""

import numpy as np
import pytest

from reports.score.events import Event
from reports.score.robustness import Robustness
from scenarios.spec.draw import concrete
from scenarios.stress.case import Case, TrialResult
from scenarios.stress.families import find_family
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.shrink import MOST_RUNS, shrink
from scenarios.stress.space import Space

SPACE = Space.of(find_family("cross"))


def made_up(share):
    """A tracker that swaps, after 20 frames, above 0.4 m/s and below 0.06 m, in this share."""

    def evaluate(cases):
        return [one(case) for case in cases]

    def one(case):
        v = case.values
        unlucky = np.random.default_rng(case.seed).random() < share
        bad = unlucky and v["speed"] > 0.4 and v["depth_gap"] < 0.06 and case.frames > 20
        rho = -1.0 if bad else 1.0
        ends = (20 if bad else -1, *(-1,) * 5)
        robustness = Robustness(rho, 1.0, 1.0, (1.0,) * 3, (0.1, 1.0, 1.0), ends)
        last = min(case.frames - 1, 20 + round(10 * float(v["hold"])))
        events = (Event("swap", 1, 2, 19, last, True, 0.0, 1.0),) if bad else ()
        return Evaluation(case, TrialResult(str(case), robustness, events, case.frames, 3.0))

    return evaluate


FAILING = Case("cross", SPACE.values_of_unit(np.linspace(0.95, 0.99, 13)), 5).with_values(
    {"speed": 0.55, "depth_gap": 0.045}
)


def test_only_what_is_needed_is_left_and_nearer_to_nominal():
    result = shrink(SPACE, FAILING, "swap", made_up(0.99))
    assert set(result.needed) == {"speed", "depth_gap"}
    assert len(result.changed) >= 10
    assert result.runs <= MOST_RUNS <= 150
    assert 0.4 < result.minimal.values["speed"] < 0.5
    assert 0.05 < result.minimal.values["depth_gap"] < 0.06
    assert result.minimal.values["frames"] == 24
    assert result.minimal_survival.failed >= 85
    assert result.minimal_survival.of == 100
    assert set(result.differences) == {"speed", "depth_gap"}


@pytest.mark.parametrize("speed", [0.55, 0.41])
def test_a_form_at_the_edge_goes_on_until_other_noise_bears_it_out(speed):
    """A tracker that fails the oftener the faster; the very edge would fail with half of all."""

    def evaluate(cases):
        return [one(case) for case in cases]

    def one(case):
        lucky = np.random.default_rng(case.seed).random()
        bad = lucky < (case.values["speed"] - 0.2) / 0.25
        robustness = Robustness(
            -1.0 if bad else 1.0, 1.0, 1.0, (1.0,) * 3, (0.1, 1.0, 1.0), (20 if bad else -1,) * 6
        )
        return Evaluation(case, TrialResult(str(case), robustness, (), case.frames, 3.0))

    case = FAILING.with_values({"speed": speed})
    result = shrink(SPACE, case, "swap", evaluate, fresh=400)
    assert result.needed == ("speed",)
    assert result.minimal.values["speed"] < 0.56
    assert result.minimal_survival.failed >= 300
    assert result.runs <= MOST_RUNS


def test_the_most_severe_is_kept_beside_the_minimal():
    result = shrink(SPACE, FAILING, "swap", made_up(1.0))
    assert result.severe_survival.severity > 2 * 2 / 54
    assert result.severe.values["hold"] > SPACE.nominal()["hold"]


def test_a_failure_of_chance_is_not_shrunk():
    result = shrink(SPACE, FAILING, "swap", made_up(0.3))
    assert result.minimal is None
    assert result.survival.failed < 6
    assert result.runs == 9  # with its own noise it does not fail either
    assert result.differences == {}


@pytest.mark.parametrize("value", ["drawn", "set"])
def test_a_failure_of_a_drawn_value_is_named(value):
    """A tracker that fails bearded people: by its seed, or whoever it is where the case says so."""

    def evaluate(cases):
        return [one(case) for case in cases]

    def one(case):
        bad = concrete(SPACE.family.scenario, case.seed, case.values)["beard"] == "yes"
        ends = (20 if bad else -1,) * 6
        rho = Robustness(-1.0 if bad else 1.0, 1.0, 1.0, (1.0,) * 3, (0.1, 1.0, 1.0), ends)
        return Evaluation(case, TrialResult(str(case), rho, (), case.frames, 3.0))

    seed = next(s for s in range(99) if one(FAILING.with_seed(s)).result.failed)
    case = FAILING.with_seed(seed)
    if value == "set":
        case = case.with_values({"beard": "yes"})
        result = shrink(Space.of(SPACE.family, ["beard"]), case, "swap", evaluate)
        assert (result.once, result.differences) == (None, {"beard": "yes"})
    else:
        result = shrink(SPACE, case, "swap", evaluate)
        assert result.once.words == "drawn: beard yes"
        assert result.minimal.values["beard"] == "yes"
        assert result.survival.failed < 6
    assert result.minimal_survival.failed == 100
    assert result.runs <= MOST_RUNS


@pytest.mark.parametrize("seed", range(8))
def test_what_luck_let_go_is_put_back(seed):
    """A tracker that fails half of the time for one parameter, and nearly always with another."""

    def evaluate(cases):
        return [one(case) for case in cases]

    def one(case):
        share = 0.98 if case.values["hold"] > SPACE.nominal()["hold"] else 0.6
        bad = case.values["speed"] > 0.59 and np.random.default_rng(case.seed).random() < share
        robustness = Robustness(
            -1.0 if bad else 1.0, 1.0, 1.0, (1.0,) * 3, (0.1, 1.0, 1.0), (20 if bad else -1,) * 6
        )
        return Evaluation(case, TrialResult(str(case), robustness, (), case.frames, 3.0))

    case = Case("cross", {**SPACE.nominal(), "speed": 0.6, "hold": 3.0}, 5)
    result = shrink(SPACE, case, "swap", evaluate, fresh=200, seed=seed)
    assert result.runs <= MOST_RUNS
    assert set(result.needed) == {"speed", "hold"}
    assert result.minimal_survival.failed >= 180
