"""The plug-in as its users have it: pytest in a process of its own, on a tiny real run."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]

# One module, so that the whole is started as seldom as can be.
TESTS = """
from pathlib import Path

import pytest
from pjpdaf.tracker.filter import PJPDAF


def make(cameras):
    return PJPDAF(cameras)


def test_runs(pjpdaf_run, assert_no_regression):
    run = pjpdaf_run("cross", seeds=1, settings={"frames": 3})
    assert run.median_error_mm < 60
    assert 0.9 <= run.within_100 <= 1
    assert (run.swapped, run.lost) == (0, 0)
    assert len(run.saved.frames) == 3 * 3
    assert run.summary.scenarios == ("cross",)
    assert run.name == "test_runs"
    verdict = assert_no_regression(run)
    assert verdict.verdict == "pass"


def test_bad_input(pjpdaf_run):
    pjpdaf_run("crss")
"""

OWN = """
def test_own(pjpdaf_run, assert_no_regression):
    assert_no_regression(pjpdaf_run("cross", seeds=1, settings={"frames": 3}, tracker="mine:make"))


def test_own_without_a_baseline(assert_no_regression):
    from reports.run.load import load
    from scenarios.run.pytest_plugin import BenchRun

    assert_no_regression(BenchRun("nothing", load(Path("base/test_own"))))
"""


def pytest_in(folder, *words):
    """Only our plug-in, so that nothing else can warn."""
    env = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")}
    env |= {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    command = [sys.executable, "-m", "pytest", "-p", "pjpdaf.pytest_plugin", "-q", *words]
    return subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, check=False)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "test_mine.py").write_text(TESTS)
    return tmp_path


def test_a_run_is_played_and_held_against_its_baseline(folder):
    words = ("-k", "runs", "--pjpdaf-baseline", "base", "--pjpdaf-jobs", "1")
    made = pytest_in(folder, *words, "--pjpdaf-update-baseline")
    assert made.returncode == 0, made.stdout
    size = sum(p.stat().st_size for p in (folder / "base" / "test_runs").iterdir())
    assert size < 60_000
    (folder / "mine.py").write_text(
        "from pjpdaf.presets.override import override\n"
        "from pjpdaf.presets.registry import find_preset\n"
        "from pjpdaf.tracker.filter import PJPDAF\n"
        "def make(cameras):\n"
        "    changed = override(find_preset('thesis'), {'measurement_px2': '1e7'})\n"
        "    return PJPDAF(cameras, changed.tracker)\n"
    )
    (folder / "test_mine.py").write_text(TESTS + OWN)
    (folder / "base" / "test_runs").rename(folder / "base" / "test_own")
    worse = pytest_in(folder, "-k", "own", *words[2:])
    assert worse.returncode == 1
    assert "base/test_own: " in worse.stdout
    assert "| error_mm |" in worse.stdout
    assert "base/nothing: no baseline; make it with --pjpdaf-update-baseline" in worse.stdout


def test_faults_are_one_line_without_a_traceback(folder):
    done = pytest_in(folder, "-k", "bad_input")
    assert done.returncode == 1
    assert "no scenario or suite 'crss'; did you mean cross?" in done.stdout
    assert "Traceback" not in done.stdout
    assert "site-packages" not in done.stdout


def test_it_imports_nothing_until_it_is_used(folder):
    code = (
        "import sys, pjpdaf.pytest_plugin;"
        "heavy = {'numpy', 'cv2', 'mujoco', 'pandas', 'scipy', 'plotly', 'pydantic', 'pyarrow'};"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], cwd=folder, env=env, check=True)
    shown = pytest_in(folder, "--help")
    for option in ("--pjpdaf-baseline=DIR", "--pjpdaf-update-baseline", "--pjpdaf-jobs=N"):
        assert option in shown.stdout
