"""Our packages in a process that has packages of the same names."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def project(tmp_path):
    """A user's project with packages of our names."""
    for name in ("sim", "reports", "scenarios"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("X = 1\n")
    return tmp_path


def python(project, *words, path):
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path))}
    env["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # nothing else can warn
    command = [sys.executable, *words]
    return subprocess.run(
        command, cwd=project, env=env, capture_output=True, text=True, check=False
    )


@pytest.mark.long
def test_the_command_finds_its_own_packages(project):
    done = python(project, "-m", "pjpdaf.entry", "scenarios", "list", path=(project, ROOT))
    assert done.returncode == 0, done.stderr
    assert "cross" in done.stdout


def test_a_broken_library_on_the_path_is_one_line(project):
    (project / "typer.py").write_text("import no_such_thing\n")
    done = python(project, "-m", "pjpdaf.entry", "run", path=(project, ROOT))
    assert done.returncode == 5
    (line,) = done.stderr.splitlines()
    assert "unforeseen: ModuleNotFoundError: No module named 'no_such_thing' (typer.py:1)" in line


SWAP = """
import sys
import time
from pjpdaf.entry import own_packages
if {first}:
    import sim, scenarios
with own_packages():
    import sim.specs
    from scenarios.cli.options import PresetName
    assert not hasattr(sys.modules["scenarios"], "X")
import sim, scenarios, reports
assert (sim.X, scenarios.X, reports.X) == (1, 1, 1)
assert "sim.specs" not in sys.modules
with own_packages():
    from sim.specs import RigSpec
    assert RigSpec is sim_specs.RigSpec if (sim_specs := sys.modules.get("sim.specs")) else False
import sim
assert sim.X == 1
"""


@pytest.mark.parametrize("first", [True, False])
def test_a_users_packages_come_back(project, first):
    done = python(project, "-c", SWAP.format(first=first), path=(project, ROOT))
    assert done.returncode == 0, done.stderr


def test_pytest_of_a_project_with_such_packages_starts(project):
    (project / "test_theirs.py").write_text(
        "import sys, scenarios\n"
        "def test_theirs(request):\n"
        "    assert scenarios.X == 1\n"
        "    assert not {'numpy', 'reports.run', 'scenarios.run'} & set(sys.modules)\n"
        "def test_fixture(assert_no_regression):\n"
        "    import reports\n"
        "    assert scenarios.X == reports.X == 1\n"
    )
    (project / "pytest.ini").write_text("[pytest]\n")
    words = ("-m", "pytest", "-q", "-p", "pjpdaf.pytest_plugin")
    done = python(project, *words, path=(project, ROOT))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_during_the_first_imports_is_one_line(project, number):
    """A library that takes its time stands for a slow disk."""
    (project / "typer.py").write_text(
        "from pathlib import Path\nimport time\nPath('begun').touch()\ntime.sleep(60)\n"
    )
    env = {**os.environ, "PYTHONPATH": f"{project}{os.pathsep}{ROOT}"}
    command = [sys.executable, "-m", "pjpdaf.entry", "run"]
    with subprocess.Popen(command, cwd=project, env=env, stderr=subprocess.PIPE) as process:
        while not (project / "begun").exists():
            time.sleep(0.02)
        process.send_signal(number)
        assert process.stderr.read().decode() == "pjpdaf-bench: interrupted\n"
    assert process.returncode == 130
