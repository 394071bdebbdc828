"""The wheel: all data files, no tests, works alone; the lock: names, versions, hashes."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder of the wheel and of the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return folder


def test_wheel_holds_all_data_files_and_no_tests(built):
    (wheel,) = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    listed = subprocess.run(
        ["git", "ls-files", "pjpdaf", "sim", "reports", "scenarios"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    wanted = {n for n in listed.stdout.split() if (ROOT / n).exists()}
    assert wanted <= names, wanted - names
    assert any(n.endswith(".yaml") for n in wanted)
    assert not [n for n in names if n.startswith(("tests/", "docs/", "examples/"))]


def test_the_source_distribution_holds_what_its_tests_and_links_need(built):
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    for name in ("bench", "requirements.lock", "CONTRIBUTING.md", "docs/pictures/drink.jpg"):
        assert name in names
    assert ".github/actions/pjpdaf-bench/action.yml" in names
    assert not [n for n in names if "__pycache__" in n or n.startswith((".venv", "runs/"))]


@pytest.mark.long  # a new environment, and a run in it
def test_an_installed_wheel_plays_outside_of_the_repository(built, tmp_path):
    (wheel,) = built.glob("*.whl")
    home = tmp_path / "env"
    venv.create(home, symlinks=True)
    python = home / "bin/python"
    words = ["--python", str(python), "install", "-q", "--no-index", "--no-deps", str(wheel)]
    subprocess.run([sys.executable, "-m", "pip", *words], check=True, capture_output=True)
    # What it needs is that of the tests' own environment; its .pth files, and so the repository,
    # are not read from there.
    (packages,) = home.glob("lib/python*/site-packages")
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    work = tmp_path / "work"
    work.mkdir()
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def bench(*arguments):
        command = [str(home / "bin/pjpdaf-bench"), *arguments]
        done = subprocess.run(command, cwd=work, env=env, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    where = [str(python), "-c", "import scenarios; print(scenarios.__file__)"]
    place = subprocess.run(where, cwd=work, env=env, capture_output=True, text=True).stdout
    assert Path(place).is_relative_to(home)
    assert "self-test: a rendered sphere is where the camera says" in bench("doctor")
    assert "calm_table" in bench("scenarios", "list")
    played = ("--seeds", "1", "--set", "frames=4", "--jobs", "1", "--out", "mine")
    assert "report: mine/report.html" in bench("run", "cross", *played)
    page = (work / "mine/report.html").read_text(encoding="utf-8")
    bench("report", "mine")
    assert (work / "mine/report.html").read_text(encoding="utf-8") == page


def test_lock_pins_by_hash_and_names_no_address():
    lock = (ROOT / "requirements.lock").read_text()
    assert "://" not in lock
    assert "--index" not in lock
    assert "--find-links" not in lock
    blocks = re.split(r"\n(?=[a-zA-Z0-9])", "\n" + lock.split("\n", 1)[1])
    pins = [b for b in blocks if "==" in b.split("\n")[0]]
    assert len(pins) > 40
    assert all("--hash=sha256:" in pin for pin in pins)


def test_one_opencv_in_the_lock():
    lock = (ROOT / "requirements.lock").read_text()
    wheels = re.findall(r"^opencv[a-z-]*(?===)", lock, flags=re.MULTILINE)
    assert wheels == ["opencv-python-headless"]
