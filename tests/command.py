"""The command as users start it: in a process of its own, or, faster, in this one."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from scenarios.cli.main import main

ROOT = Path(__file__).parents[1]
COMMAND = (sys.executable, "-m", "scenarios")
ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "MUJOCO_GL"} | {"PYTHONPATH": str(ROOT)}


def bench(*words, cwd=ROOT, **environment):
    """The finished process of the command with these words."""
    return subprocess.run(
        [*COMMAND, *map(str, words)],
        cwd=cwd,
        env=ENVIRONMENT | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def in_this_process(monkeypatch, capsys, *words):
    """The same without the two seconds in which a new process loads everything."""
    monkeypatch.setattr(sys, "argv", ["pjpdaf-bench", *map(str, words)])
    with pytest.raises(SystemExit) as end:
        main()
    output = capsys.readouterr()
    return subprocess.CompletedProcess(words, end.value.code, output.out, output.err)


def assert_one_line(done, code, *fragments):
    """The command ended with this exit code and a single line that has all fragments."""
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    for fragment in fragments:
        assert fragment in lines[0], lines[0]
