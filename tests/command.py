"""The command as users start it: in a process of its own, or, faster, in this one."""

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
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


def in_this_process(*words):
    """The same without the seconds in which a new process loads everything."""
    output, errors = io.StringIO(), io.StringIO()
    code = None
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(output), redirect_stderr(errors):
        patch.setattr(sys, "argv", ["pjpdaf-bench", *map(str, words)])
        try:
            main()
        except SystemExit as end:
            code = end.code
    return subprocess.CompletedProcess(words, code, output.getvalue(), errors.getvalue())


def assert_one_line(done, code, *fragments):
    """The command ended with this exit code and a single line that has all fragments."""
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    for fragment in fragments:
        assert fragment in lines[0], lines[0]
