"""Exceptions of a user's code in one line."""

import pytest

from pjpdaf.errors import BenchError
from pjpdaf.plugins.loading import describe_exception
from pjpdaf.plugins.registry import make_tracker
from pjpdaf.plugins.scenes import cameras_in_front


def test_the_place_is_that_of_the_users_line():
    try:
        raise ValueError("two\nlines \x1b[31m")
    except ValueError as fault:
        text = describe_exception(fault)
    assert text.startswith("ValueError: two lines \\x1b[31m")


def test_code_that_does_not_parse_names_its_own_place_once(tmp_path, monkeypatch):
    (tmp_path / "unparsed_tracker.py").write_text("x = (\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(BenchError) as fault:
        make_tracker("unparsed_tracker:make", cameras_in_front())
    assert str(fault.value) == (
        "The tracker 'unparsed_tracker:make' cannot be imported: SyntaxError: '(' was never closed "
        "(unparsed_tracker.py, line 1)."
    )
