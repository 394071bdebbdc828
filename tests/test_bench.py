"""The wrapper ./bench: where it finds itself, when it sets up, and its one-line stops."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOOLS = [
    "cat",
    "cksum",
    "df",
    "dirname",
    "env",
    "grep",
    "id",
    "ls",
    "mkdir",
    "printf",
    "readlink",
    "sed",
    "sh",
    "tail",
]
NO_ROOM = "needed_mb=1700"


@pytest.fixture
def tools(tmp_path):
    """A folder for PATH with the shell's tools and no Python."""
    folder = tmp_path / "tools"
    folder.mkdir()
    for name in TOOLS:
        if found := shutil.which(name):
            (folder / name).symlink_to(found)
    return folder


@pytest.fixture
def checkout(tmp_path):
    """What ./bench reads of a checkout, at a path with a space and an umlaut."""
    folder = tmp_path / "my chäckout"
    folder.mkdir()
    for name in ("bench", "requirements.lock", "pyproject.toml"):
        shutil.copy2(ROOT / name, folder / name)
    return folder


@pytest.fixture
def ready(checkout):
    """A checkout that believes itself set up; its command prints its arguments."""
    venv = checkout / ".venv"
    (venv / "bin").mkdir(parents=True)
    (venv / "lib/python3.11/site-packages/numpy").mkdir(parents=True)
    (venv / "bin/python").symlink_to(sys.executable)
    script(venv / "bin/pjpdaf-bench", 'printf "<%s>" "$@"')
    (venv / ".bench-packages").write_text("numpy\n")
    (venv / ".bench-python").write_text("python3")
    (venv / ".bench-gl").touch()
    wrapper = (checkout / "bench").read_text()
    stamp_now = wrapper[wrapper.index("stamp_now() {") : wrapper.index("\nup_to_date() {")]
    command = ["sh", "-c", f"here=$1 venv=$1/.venv\n{stamp_now}\nstamp_now", "sh", str(checkout)]
    stamp = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    (venv / ".bench-stamp").write_text(stamp)
    return checkout


def script(path, text):
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def start(checkout, *arguments, path=None, shell=(), cwd=None, **environment):
    environment = {"PATH": str(path or os.environ["PATH"]), "HOME": "/nonexistent", **environment}
    return subprocess.run(
        [*shell, str(checkout / "bench"), *arguments],
        env=environment,
        cwd=cwd,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        timeout=30,
    )


def assert_stops(done, code, *words):
    """One line on standard error says why; nothing else is printed."""
    assert done.returncode == code, done.stderr
    assert done.stdout == ""
    (line,) = [line for line in done.stderr.splitlines() if "making .venv" not in line]
    assert line.startswith("bench: stopped: ")
    for word in words:
        assert word in line


@pytest.mark.parametrize("shell", ["sh", "dash", "bash", "busybox"])
def test_starts_with_every_shell(ready, shell):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    command = ("busybox", "sh") if shell == "busybox" else (shell,)
    done = start(ready, "run", "a b", "", "*", shell=command)
    assert (done.stdout, done.stderr, done.returncode) == ("<run><a b><><*>", "", 0)


def test_found_through_links_and_from_anywhere(ready, tmp_path):
    elsewhere = tmp_path / "else where"
    elsewhere.mkdir()
    (elsewhere / "first").symlink_to("../my chäckout/bench")
    (elsewhere / "bench").symlink_to("first")
    assert start(elsewhere, "list", cwd="/").stdout == "<list>"
    assert start(Path(), "list", cwd=elsewhere, shell=("sh",)).stdout == "<list>"


@pytest.mark.parametrize(
    "environment",
    [
        {"PYTHONHOME": "/nonsense", "PYTHONPATH": "/nonsense", "VIRTUAL_ENV": "/nonsense"},
        {"LC_ALL": "C"},
        {"CDPATH": "/tmp"},
        {"CI": "true"},
        {"MUJOCO_GL": ""},
    ],
    ids=lambda e: next(iter(e)),
)
def test_environment_does_not_matter(ready, environment):
    assert start(ready, "scenarios", **environment).stdout == "<scenarios>"


def test_a_file_of_pip_cannot_send_packages_elsewhere(tmp_path):
    """pip refuses `user = true` in a virtual environment; the wrapper's environment beats it."""
    settings = tmp_path / "pip.conf"
    settings.write_text("[global]\nuser = true\n")
    wrapper = (ROOT / "bench").read_text()
    lines = wrapper[wrapper.index("  unset PIP_TARGET") : wrapper.index('  if ! "$python" -I')]
    show = f"{lines}\n'{sys.executable}' -I -m pip config debug"
    env = {**os.environ, "PIP_CONFIG_FILE": str(settings)}
    done = subprocess.run(["sh", "-c", show], env=env, capture_output=True, text=True, check=True)
    assert "PIP_USER='0'" in done.stdout
    assert "global.user: true" in done.stdout


def test_no_python_is_one_line(checkout, tools):
    assert_stops(start(checkout, "run", path=tools), 5, "no Python 3.11", "PJPDAF_PYTHON=")


def test_old_python_and_dead_shim_are_passed_over(checkout, tools):
    script(tools / "python3", "exit 1")
    script(tools / "python3.13", "echo 'shim: no such version' >&2; exit 127")
    assert_stops(start(checkout, "run", path=tools), 5, "no Python 3.11")


def test_named_python_must_start(checkout):
    done = start(checkout, "run", PJPDAF_PYTHON="/no such/python")
    assert_stops(done, 5, "PJPDAF_PYTHON=/no such/python")


def test_python_without_venv_names_the_package(checkout, tools):
    real = sys.executable
    script(
        tools / "python3",
        f"""case "$*" in *ensurepip*) exit 1 ;; esac\nexec '{real}' "$@" """,
    )
    done = start(checkout, "run", path=tools)
    package = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
    assert_stops(done, 5, f"sudo apt-get install {package}")


def test_disk_without_room_is_one_line(checkout):
    wrapper = checkout / "bench"
    text = wrapper.read_text()
    assert NO_ROOM in text
    wrapper.write_text(text.replace(NO_ROOM, "needed_mb=999999999999"))
    assert_stops(start(checkout, "run", PJPDAF_PYTHON=sys.executable), 5, "has room for", "MB")


@pytest.mark.skipif(os.getuid() == 0, reason="root writes everywhere")
def test_read_only_checkout_is_one_line(checkout):
    checkout.chmod(0o555)
    try:
        assert_stops(start(checkout, "run"), 5, "cannot write", "writable")
    finally:
        checkout.chmod(0o755)


def sets_up(done):
    """Did it begin to make .venv? (The Python that it is given then fails.)"""
    return "making .venv" in done.stderr


def broken_python(folder):
    """A Python that starts, and whose venv fails."""
    return script(
        folder / "python",
        f"""case "$*" in *-m\\ venv*) exit 1 ;; esac\nexec '{sys.executable}' "$@" """,
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda c: (c / "requirements.lock").write_text("numpy==1\n"),
        lambda c: (c / "pyproject.toml").write_text("[project]\n"),
        lambda c: (c / ".venv/lib/python3.11/site-packages/numpy").rmdir(),
        lambda c: (c / ".venv/bin/python").unlink(),
        lambda c: (c / ".venv/.bench-stamp").unlink(),
        lambda c: (c / ".venv/.bench-python").write_text("another"),
    ],
    ids=["lock", "metadata", "package gone", "python gone", "set-up unfinished", "other python"],
)
def test_sets_up_again_after_a_change(ready, tmp_path, change):
    python = broken_python(tmp_path)
    (ready / ".venv/.bench-python").write_text(str(python))
    assert not sets_up(start(ready, "list", PJPDAF_PYTHON=str(python)))
    change(ready)
    done = start(ready, "list", PJPDAF_PYTHON=str(python))
    assert sets_up(done)
    assert done.returncode == 5
    assert "venv fails" in done.stderr.splitlines()[-1]


def test_moved_checkout_sets_up_again(ready, tmp_path):
    moved = ready.rename(tmp_path / "moved")
    python = broken_python(tmp_path)
    assert sets_up(start(moved, "list", PJPDAF_PYTHON=str(python)))


def test_packages_that_the_user_added_stay(ready):
    (ready / ".venv/lib/python3.11/site-packages/mine").mkdir()
    assert start(ready, "list").stdout == "<list>"


def test_second_start_waits_for_the_first_and_outlives_its_death(checkout, tmp_path):
    python = script(
        tmp_path / "python",
        f"""case "$*" in *-m\\ venv*) sleep 2; exit 1 ;; esac\nexec '{sys.executable}' "$@" """,
    )
    environment = {**os.environ, "PJPDAF_PYTHON": str(python)}
    command = [str(checkout / "bench"), "list"]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as first:
        while "making .venv" not in first.stderr.readline():
            assert first.poll() is None
        time.sleep(0.3)
        first.send_signal(signal.SIGKILL)
        second = start(checkout, "list", PJPDAF_PYTHON=str(python))
    lines = second.stderr.splitlines()
    assert "waiting for another bench" in lines[0]
    assert "making .venv" in lines[1]
    assert "venv fails" in lines[2]


def use_python(ready, text):
    """Put a script in the place of Python, and let the checkout believe that it was always so."""
    python, stamp = ready / ".venv/bin/python", ready / ".venv/.bench-stamp"
    python.unlink()
    script(python, text)
    lines = stamp.read_text().splitlines()
    stamp.write_text("\n".join([*lines[:-1], str(python)]) + "\n")


def gl_fails(ready):
    (ready / ".venv/.bench-gl").unlink()
    message = "no offscreen OpenGL here (missing libEGL.so.1); apt-get install libegl1"
    use_python(ready, f"echo '{message}' >&2; exit 1")


def test_no_opengl_is_one_line_where_it_is_needed(ready, tools):
    gl_fails(ready)  # and no apt-get in PATH
    done = start(ready, "run", path=tools)
    assert done.returncode == 5
    said, stopped = done.stderr.splitlines()
    assert said == "bench: checking that OpenGL renders offscreen"
    assert stopped.startswith(
        "bench: stopped: no offscreen OpenGL here (missing libEGL.so.1); run: "
    )
    assert stopped.count("apt-get") == 1


@pytest.mark.parametrize(
    "arguments", [["scenarios", "list"], ["report", "x"], ["run", "--help"], ["--version"]], ids=str
)
def test_opengl_is_not_asked_for_where_nothing_is_rendered(ready, tools, arguments):
    gl_fails(ready)
    done = start(ready, *arguments, path=tools)
    assert (done.returncode, done.stderr) == (0, "")


def test_broken_mujoco_gl_is_left_to_the_command(ready, tools):
    gl_fails(ready)
    assert start(ready, "run", path=tools, MUJOCO_GL="potato").stdout == "<run>"


@pytest.mark.parametrize(
    ("faulty", "tests", "code", "said"),
    [
        (None, 0, 0, ["played"]),
        (None, 3, 3, ["played"]),
        (None, 1, 1, ["played", "played"]),  # once more what failed
        ("ruff", 0, 1, ["ruff is unhappy", "bench: stopped: ruff check . found faults"]),
        ("lint-imports", 0, 1, ["lint-imports is unhappy", "lint-imports found faults"]),
        ("mypy", 0, 1, ["played", "mypy is unhappy", "bench: stopped: mypy found faults"]),
        ("mypy", 3, 1, ["played", "mypy is unhappy", "bench: stopped: mypy found faults"]),
    ],
)
def test_checks_come_before_the_tests_and_types_beside_them(
    ready, tools, faulty, tests, code, said
):
    use_python(ready, f"echo played >&2; exit {tests}")
    for name in ("ruff", "lint-imports", "mypy"):
        script(
            ready / f".venv/bin/{name}", f"echo {name} is unhappy; exit 1" if name == faulty else ""
        )
    done = start(ready, "test", path=tools)
    assert done.returncode == code, done.stderr
    ends = [line for line in done.stderr.splitlines() if "unhappy" in line or "played" in line]
    ends += [line for line in done.stderr.splitlines() if "stopped" in line]
    assert len(ends) == len(said)
    for line, fragment in zip(ends, said, strict=True):
        assert fragment in line


def test_gl_module_says_what_renders_or_why_not():
    command = [sys.executable, "-m", "sim.gl"]
    environment = {**os.environ, "MUJOCO_GL": "potato"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "MUJOCO_GL=potato" in done.stderr
