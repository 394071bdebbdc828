"""Delta debugging against the sets that are known to be needed."""

from hypothesis import given
from hypothesis import strategies as st

from scenarios.stress.minimise import minimal_changes

NAMES = tuple("abcdefghijklm")


@given(st.sets(st.sampled_from(NAMES), max_size=4))
def test_what_is_needed_is_kept_and_nothing_else(needed):
    asked = []

    def fails_with(names):
        asked.append(names)
        return needed <= set(names)

    assert minimal_changes(NAMES, fails_with) == tuple(n for n in NAMES if n in needed)
    assert len(asked) <= 40


def test_a_change_that_another_makes_needed_goes_in_a_second_round():
    # `a` is needed only beside `b`, and `b` goes.
    def fails_with(names):
        return "c" in names and ("a" in names or "b" not in names)

    assert minimal_changes(tuple("abc"), fails_with) == ("c",)
