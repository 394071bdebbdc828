"""The command line of `stress`: the target and its verb, in either order."""

import pytest
from commands import assert_one_line, in_this_process

from scenarios.cli.stress import FAMILY_NAMES
from scenarios.stress.families import FAMILIES


def test_the_help_names_every_family():
    assert tuple(FAMILIES) == FAMILY_NAMES
    shown = " ".join(in_this_process("stress", "--help").stdout.split())
    assert ", ".join(FAMILY_NAMES) in shown


@pytest.mark.parametrize("words", [("croos", "search"), ("search", "croos")])
def test_the_verb_may_come_first(words):
    assert_one_line(in_this_process("stress", *words), 2, "did you mean cross?")


def test_a_verb_without_a_target_has_its_help():
    first, second = (
        in_this_process("stress", *words, "--help").stdout for words in (("all", "map"), ("map",))
    )
    assert first == second
    assert "--cells" in first
