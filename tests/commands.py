"""The command in processes of its own, which get real signals, or, faster, in this process."""

import io
import os
import subprocess
import sys
import time
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path

import pytest

from scenarios.cli.main import main

ROOT = Path(__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
LIMIT_S = 300.0  # for a slow machine; nothing takes that long where all is well


def command(*words):
    """The command line of `pjpdaf-bench WORDS`."""
    return [sys.executable, "-m", "pjpdaf.entry", *map(str, words)]


def started(*words, **options):
    """`pjpdaf-bench WORDS` in a session of its own, its standard error in a pipe."""
    options = {"stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL, "text": True, **options}
    return subprocess.Popen(command(*words), env=ENVIRONMENT, start_new_session=True, **options)


def wait_until(condition, process=None, limit_s=LIMIT_S):
    """The first true value of `condition()`; fails where the process ends before."""
    end = time.monotonic() + limit_s
    while not (value := condition()):
        assert process is None or process.poll() is None, process.communicate()
        assert time.monotonic() < end, condition
        time.sleep(0.02)
    return value


def pending(pid):
    """Whether a process has signals that it has not received yet."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return any(int(x.split()[1], 16) for x in lines if x.startswith(("SigPnd", "ShdPnd")))


def worker_pids(pid):
    """Process ids of the workers of a process: they are forked from its server."""
    return [child for server in server_pids(pid) for child in _spawned(server)]


def server_pids(pid):
    """Process ids of the servers that a process started for its workers; one, or none yet."""
    return _spawned(pid)


def _spawned(pid):
    """Children of a process that run Python code of its (not Python's own resource tracker)."""
    pids = []
    try:  # a child is that of the thread that started it
        threads = list(Path(f"/proc/{pid}/task").iterdir())
        children = " ".join((thread / "children").read_text() for thread in threads).split()
    except (FileNotFoundError, ProcessLookupError):  # it has ended
        return pids
    for child in children:
        with suppress(FileNotFoundError, ProcessLookupError):
            words = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            if any(b"spawn_main" in word for word in words):
                pids.append(int(child))
    return pids


def bench(*words, cwd=ROOT, **environment):
    """The finished process of `pjpdaf-bench WORDS`."""
    clean = {name: value for name, value in ENVIRONMENT.items() if name != "MUJOCO_GL"}
    return subprocess.run(
        command(*words),
        cwd=cwd,
        env=clean | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def in_this_process(*words):
    """The same, without the seconds in which a new process loads everything."""
    output, errors = io.StringIO(), io.StringIO()
    code = None
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(output), redirect_stderr(errors):
        patch.setattr(sys, "argv", ["pjpdaf-bench", *map(str, words)])
        try:
            main()
        except SystemExit as end:
            code = end.code
    return subprocess.CompletedProcess(words, code, output.getvalue(), errors.getvalue())


def messages(done):
    """What the command said on standard error, but for the progress that a slow machine prints."""
    lines = done.stderr.strip().splitlines()
    return [line for line in lines if not line.startswith("progress: ")]


def assert_one_line(done, code, *fragments):
    """The command ended with this exit code and a single line that has all fragments."""
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    lines = messages(done)
    assert len(lines) == 1, done.stderr
    for fragment in fragments:
        assert fragment in lines[0], lines[0]
