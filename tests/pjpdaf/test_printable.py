"""Text of strangers on a terminal."""

import pytest

from pjpdaf.errors import BenchError
from pjpdaf.printable import for_terminal, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, with ü and 3 × 3", "plain, with ü and 3 × 3"),
        ("a\x1b]0;title\x07b", r"a\x1b]0;title\x07b"),
        ("two\nlines\r", r"two\nlines\r"),
        ("\u202egnp.exe", r"\u202egnp.exe"),
        ("half \ud800", r"half \ud800"),
    ],
)
def test_one_line_is_harmless(text, shown):
    assert printable(text) == shown
    assert str(BenchError(text)) == shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[1mbold\x1b[0m\n\tcell\r", "\x1b[1mbold\x1b[0m\n\tcell\r"),
        ("\x1b[?25l\x1b[2K\x1b[1A", "\x1b[?25l\x1b[2K\x1b[1A"),
        ("\x1b]52;c;aGk=\x07", r"\x1b]52;c;aGk=\x07"),
        ("\x1b[5n \x9b6n \x00", r"\x1b[5n \x9b6n \x00"),
        ("\x1b]8;;http://x\x1b\\here", r"\x1b]8;;http://x\x1b\here"),
    ],
)
def test_of_control_sequences_only_colours_and_moves_reach_a_terminal(text, shown):
    assert for_terminal(text) == shown
