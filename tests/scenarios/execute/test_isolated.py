"""What somebody else's code may do to an interpreter, and what is said of it."""

import sys
import textwrap

import pytest
from typer.testing import CliRunner

from pjpdaf.errors import BenchError
from scenarios.cli.main import app
from scenarios.execute.isolated import Ended, isolated, try_plug_ins

PLUG_INS = """
    import os
    import time

    def ends(cameras):
        os._exit(7)

    def hangs(cameras):
        time.sleep(1000)

    def raises(cameras):
        raise ValueError("no such network")

    class EndsLater:
        def start(self, seen):
            os._exit(9)

        step = estimates = predict = start

    def ends_later(cameras):
        return EndsLater()
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    (tmp_path / "trouble.py").write_text(textwrap.dedent(PLUG_INS))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def test_code_that_ends_the_interpreter_is_a_fault_of_one_line(here):
    with pytest.raises(Ended, match=r"'trouble:ends' ends the interpreter \(exit code 7\)"):
        try_plug_ins("thesis", "trouble:ends")


def test_code_that_hangs_is_a_fault_of_one_line(here):
    with pytest.raises(Ended, match=r"detector 'trouble:hangs' gives no answer within 3 s"):
        try_plug_ins("trouble:hangs", "thesis", limit_s=3.0)


def test_code_that_raises_is_told_as_ever(here):
    with pytest.raises(BenchError, match=r"cannot be built: ValueError: no such network"):
        try_plug_ins("thesis", "trouble:raises")


def test_presets_start_no_process(monkeypatch):
    monkeypatch.setattr("scenarios.execute.isolated.WorkerPool", None)
    try_plug_ins("thesis", "thesis-literal")


def test_an_answer_comes_back():
    assert isolated("sum", 60.0, sum, [1, 2, 3]) == 6


@pytest.mark.parametrize("name", ["ends", "ends_later"])
def test_plugin_check_says_it_and_exits_with_1(here, name):
    done = CliRunner().invoke(app, ["plugin", "check", f"trouble:{name}", "--limit", "3"])
    assert done.exit_code == 1
    assert "ends the interpreter" in done.stdout
    assert done.stdout.count("\n") == 1


def test_a_run_stops_before_it_plays_anything(here):
    words = ["run", "calm_table", "--tracker", "trouble:ends", "--out", str(here / "run")]
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, Ended)
    assert not (here / "run").exists()
    assert "trouble" not in sys.modules
