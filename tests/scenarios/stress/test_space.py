"""Coordinates of the space: range, nominal distribution, and the way back."""

import numpy as np
import pytest
from scipy.stats import kstest

from pjpdaf.errors import BenchError
from scenarios.play.job import System
from scenarios.spec.draw import concrete
from scenarios.stress.case import Case
from scenarios.stress.families import FAMILIES, find_family
from scenarios.stress.space import Space


@pytest.mark.parametrize("name", FAMILIES)
def test_every_point_of_every_family_is_a_concrete_scenario(name):
    family = find_family(name)
    space = Space.of(family, also=("fps",))
    d = len(space.axes)
    for u in (np.zeros(d), np.ones(d), np.linspace(0, 1, d)):
        values = space.values_of_unit(u)
        back = space.values_of_unit(space.unit_of_values(values))
        for axis in space.axes:
            again = back[axis.name]
            assert again == (values[axis.name] if axis.choices else pytest.approx(again, rel=1e-5))
        job = Case(name, values, 3).job(system())
        drawn = concrete(job.scenario, 3, job.overrides)
        assert {n: drawn[n] for n in values if n != "fps"} == {
            n: v for n, v in values.items() if n != "fps"
        }
    assert (
        Case(name, space.nominal(), 0).job(system()).overrides["frames"] == family.scenario.frames
    )


def system():
    return System("thesis", "thesis")


def test_unit_is_uniform_over_the_range_and_by_logarithm_where_the_nominal_is():
    space = Space.of(find_family("cross"))
    middle = space.values_of_unit(np.full(len(space.axes), 0.5))
    assert middle["hold"] == pytest.approx((0.5 + 6) / 2)
    assert middle["speed"] == pytest.approx(np.sqrt(0.1 * 0.6), rel=1e-5)
    assert space.values_of_unit(np.full(len(space.axes), 0.49))["front"] == "right"


def test_latent_points_are_nominally_distributed():
    space = Space.of(find_family("drink"))
    z = np.random.default_rng(0).normal(size=(1000, len(space.axes)))
    values = [space.values_of_latent(row) for row in z]
    speed = space.axis("speed").parameter
    shares = [speed.cdf(float(v["speed"])) for v in values]
    assert kstest(shares, "uniform").pvalue > 0.01
    assert np.mean([v["hand"] == "right" for v in values]) == pytest.approx(0.75, abs=0.05)


def test_nominal_is_median_and_mode():
    nominal = Space.of(find_family("drink")).nominal()
    assert (nominal["hand"], nominal["speed"]) == ("right", pytest.approx(0.575))


def test_parameters_may_be_fixed_added_and_narrowed():
    family = find_family("cross")
    space = Space.of(family, also=("fps",), fixed={"hold": "3 s"}, ranges={"speed": (0.2, 0.3)})
    assert "hold" not in space.names
    assert space.nominal()["hold"] == 3.0
    assert space.nominal()["fps"] == 3.0
    assert space.values_of_unit(np.ones(len(space.axes)))["speed"] == pytest.approx(0.3)
    assert space.axis("fps").of_unit(0.5) == pytest.approx(np.sqrt(30), rel=1e-5)


@pytest.mark.parametrize(
    ("keywords", "line"),
    [
        ({"also": ("speeed",)}, "cross has no parameter 'speeed' to vary; did you mean speed?"),
        ({"ranges": {"speed": (0.3, 0.2)}}, "speed: range is reversed: 0.3 is greater than 0.2"),
        (
            {"ranges": {"speed": (0.0, 0.2)}},
            "speed: 0 to 0.2 is outside its range 0.1 to 0.6 m/s",
        ),
        ({"ranges": {"front": (0.0, 1.0)}}, "front: is one of right, left; it has no range"),
        ({"fixed": {"speed": 9}}, "speed: 9 m/s is outside its range 0.1 to 0.6 m/s"),
        ({"fixed": {"front": "rihgt"}}, "did you mean right?"),
    ],
)
def test_faults_are_a_line(keywords, line):
    with pytest.raises(BenchError) as fault:
        Space.of(find_family("cross"), **keywords)
    assert line in str(fault.value)


def test_unknown_family_names_the_closest():
    with pytest.raises(BenchError, match="no family 'croos' to stress; did you mean cross"):
        find_family("croos")


def test_fps_changes_the_number_of_frames_and_not_the_time():
    case = Case("cross", {"fps": 6.0}, 0)
    assert case.job(system()).overrides["frames"] == 108
    cut = case.with_values({"frames": 20})
    assert cut.job(system()).overrides["frames"] == 20
