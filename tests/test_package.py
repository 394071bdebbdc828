"""The wheel: all data files, no tests; the lock: names, versions, hashes."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_wheel_holds_all_data_files_and_no_tests(tmp_path):
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
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
