"""Numbers of a script: plain, with units, sums of parameters."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.spec.motion.expression import parse_expression
from scenarios.spec.parameters.parameter import uniform

VALUES = {"a": 0.3, "b": -2.0, "long_name_2": 7.0}


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.3", "m", 0.3),
        ("30 cm", "m", 0.3),
        ("1e-3", "m", 1e-3),
        ("90 deg", "rad", math.pi / 2),
        ("a", "m", 0.3),
        ("-a", "m", -0.3),
        ("2*a", "m", 0.6),
        ("0.5*a + b", "m", -1.85),
        ("a - 2 * b", "m", 4.3),
        ("a + 3 cm", "m", 0.33),
        ("0.1 + a", "m", 0.4),
        ("long_name_2-a", "m", 6.7),
    ],
)
def test_its_value(text, unit, value):
    assert parse_expression(text, unit).value(VALUES) == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    "text", ["", "a b", "a*b", "2*", "a +", "a ++ b", "(a)", "__import__('os')", "a" + " + a" * 20]
)
def test_anything_else_is_refused(text):
    with pytest.raises(ValueError, match="must be"):
        parse_expression(text, "m")


@given(
    st.lists(
        st.tuples(st.integers(0, 99), st.sampled_from(sorted(VALUES)), st.sampled_from("+-")),
        min_size=1,
        max_size=6,
    )
)
def test_a_sum_is_what_python_makes_of_it(terms):
    text = "0" + "".join(f" {sign} {factor}*{name}" for factor, name, sign in terms)
    assert parse_expression(text, "m").value(VALUES) == pytest.approx(eval(text, {}, dict(VALUES)))


def test_its_ends_are_those_of_its_parameters_in_the_base_unit():
    numbers = {"a": uniform("cm", (10, 20), 10, 20, ""), "b": uniform("m", (0, 1), 0, 1, "")}
    assert parse_expression("2*a - b + 1", "m").ends(numbers) == pytest.approx((0.2, 1.4))
