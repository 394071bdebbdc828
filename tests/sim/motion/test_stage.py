"""What a family plans with: values that are no numbers are refused by name."""

import pytest

from pjpdaf.errors import BenchError
from sim.motion.stage import number


def test_a_number_is_told():
    assert number({"speed": 0.5}, "speed") == 0.5


def test_a_choice_where_a_number_is_needed_is_one_clear_line():
    with pytest.raises(BenchError) as fault:
        number({"speed": "fast"}, "speed")
    assert str(fault.value) == (
        "parameter speed: must be a number in this family of motion, got 'fast'; "
        "give it a unit, a range and a nominal distribution instead of choices or a file"
    )
