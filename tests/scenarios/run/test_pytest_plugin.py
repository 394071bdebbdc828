"""The plug-in as its users have it, on a tiny real run."""

import io
import os
import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest
from made_dataset import made_dataset

ROOT = Path(__file__).parents[3]

# One module, so that the whole is started as seldom as can be.
TESTS = """
from pathlib import Path

import pytest

SHORT = {"frames": 3, "background_frames": 2, "detector.background_learn_min": 2}
from pjpdaf.tracker.filter import PJPDAF


def make(cameras):
    return PJPDAF(cameras)


def test_runs(pjpdaf_run, assert_no_regression):
    run = pjpdaf_run("cross", seeds=1, settings=SHORT)
    assert run.median_error_mm < 60
    assert 0.9 <= run.within_100 <= 1
    assert (run.swapped, run.lost) == (0, 0)
    assert len(run.saved.frames) == 3 * 3
    assert run.summary.scenarios == ("cross",)
    assert run.name == "test_runs"
    verdict = assert_no_regression(run)
    assert verdict.verdict == "pass"


def test_a_data_set(pjpdaf_run, request):
    settings = {"detector.background_learn_min": 2}
    folder = Path(request.config.rootpath) / "set"
    run = pjpdaf_run(dataset=folder, preset="thesis", settings=settings, first_seed=101)
    assert run.saved.meta["preset"] == run.saved.meta["tracker"] == "thesis"
    assert [scenario["seeds"] for scenario in run.saved.meta["scenarios"]] == [[101], [101]]


def test_before(pjpdaf_run, assert_no_regression):
    pjpdaf_run("cross", seeds=1, settings=SHORT)


def test_bad_input(pjpdaf_run):
    pjpdaf_run("crss")
"""

OWN = """
def test_own_other(pjpdaf_run, assert_no_regression):
    pjpdaf_run("cross", seeds=2, settings=SHORT)


def test_own(pjpdaf_run, assert_no_regression):
    assert_no_regression(pjpdaf_run("cross", seeds=1, settings=SHORT, tracker="mine:make"))


def test_own_without_a_baseline(assert_no_regression):
    from reports.run.load import load
    from scenarios.run.pytest_plugin import BenchRun

    assert_no_regression(BenchRun("nothing", load(Path("base/test_own"))))
"""


@pytest.fixture
def pytest_here(folder, monkeypatch):
    """The same as `pytest_in`, in this process: without the seconds in which all is loaded."""
    for name in [name for name in os.environ if name.startswith("PYTEST_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PJPDAF_BENCH_CACHE", str(folder / "cache"))
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(folder)

    def run(*words):
        output = io.StringIO()
        with redirect_stdout(output):
            code = pytest.main(["-p", "pjpdaf.pytest_plugin", "-q", *words])
        for name in ("test_mine", "mine"):
            sys.modules.pop(name, None)
        return subprocess.CompletedProcess(words, code, output.getvalue())

    return run


def pytest_in(folder, *words):
    """Only our plug-in, so that nothing else can warn; in a process of its own."""
    env = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")}
    env |= {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    env |= {"PJPDAF_BENCH_CACHE": str(folder / "cache")}
    command = [sys.executable, "-m", "pytest", "-p", "pjpdaf.pytest_plugin", "-q", *words]
    return subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, check=False)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "test_mine.py").write_text(TESTS)
    return tmp_path


def test_a_run_is_played_and_held_against_its_baseline(folder, pytest_here, tmp_path_factory):
    (folder / "set").symlink_to(made_dataset(tmp_path_factory))
    words = ("-k", "runs or data_set", "--pjpdaf-baseline", "base", "--pjpdaf-jobs", "1")
    made = pytest_here(*words, "--pjpdaf-update-baseline")
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
    shutil.copytree(folder / "base" / "test_own", folder / "base" / "test_own_other")
    worse = pytest_here("-k", "own or before", *words[2:], "--basetemp", "played")
    assert worse.returncode == 1
    assert "base/test_own: " in worse.stdout
    assert "| error_mm |" in worse.stdout
    assert "base/nothing: no baseline; make it with --pjpdaf-update-baseline" in worse.stdout
    assert "base/test_before: no baseline; make it with --pjpdaf-update-baseline" in worse.stdout
    assert [path.parent.name for path in (folder / "played").rglob("pjpdaf")] == ["test_own0"]
    assert "base/test_own_other: is the baseline of other scenarios, seeds or s" in worse.stdout
    assert "footage: all from the cache" in worse.stdout
    assert "1 episode of 1 scenario: " in worse.stdout


def test_faults_are_one_line_without_a_traceback(folder):
    done = pytest_in(folder, "-k", "bad_input or before")
    assert done.returncode == 1
    assert "no scenario or suite 'crss'; did you mean cross?" in done.stdout
    assert "assert_no_regression needs --pjpdaf-baseline DIR" in done.stdout
    assert "Traceback" not in done.stdout
    assert "site-packages" not in done.stdout


def test_it_imports_nothing_until_it_is_used(folder):
    code = (
        "import sys, pjpdaf.pytest_plugin;"
        "heavy = {'numpy', 'cv2', 'mujoco', 'pandas', 'scipy', 'pydantic', 'pyarrow'};"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], cwd=folder, env=env, check=True)
    shown = pytest_in(folder, "--help")
    for option in ("--pjpdaf-baseline=DIR", "--pjpdaf-update-baseline", "--pjpdaf-jobs=N"):
        assert option in shown.stdout
