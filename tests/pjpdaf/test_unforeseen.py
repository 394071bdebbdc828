"""An exception that nobody foresaw."""

import re
from pathlib import Path

import pytest

from pjpdaf.unforeseen import report_unforeseen


class Malicious(Exception):
    def __str__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        (ValueError("two\nlines \x1b[0m"), r"ValueError: two lines \x1b[0m (test_unforeseen.py:"),
        (Malicious(), "Malicious (test_unforeseen.py:"),
    ],
)
def test_one_line_names_the_file_of_the_traceback(fault, text, capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(type(fault)) as caught:
        raise fault
    assert report_unforeseen(caught.value) == 5
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"pjpdaf-bench: unforeseen: {text}")
    kept = Path(re.search(r"traceback is in (\S+) \(--debug shows it\)", line)[1])
    assert kept.parent == tmp_path
    assert "raise fault" in kept.read_text()


def test_without_room_for_the_file_the_line_says_so(capsys, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", "/nowhere/at/all")
    report_unforeseen(ValueError("x"), debug=True)
    errors = capsys.readouterr().err
    assert errors.splitlines()[-1].endswith("ValueError: x; its traceback cannot be written here")
    assert "ValueError: x" in errors.splitlines()[0]
