"""The verbs of the gate: folders that are not runs."""

import pytest
from commands import assert_one_line, in_this_process


@pytest.mark.parametrize(
    "words", [("compare", "nowhere", "there"), ("baseline", "accept", "nowhere", "there")]
)
def test_a_folder_that_is_not_a_run_is_one_line(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_one_line(in_this_process(*words), 2, "nowhere", "no such run")
    assert list(tmp_path.iterdir()) == []
