"""Imports go one way; the contract is in pyproject.toml."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_import_contract_is_kept():
    done = subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_package_inits_are_docstrings_alone():
    for package in ("pjpdaf", "sim", "reports", "scenarios"):
        text = (ROOT / package / "__init__.py").read_text().strip()
        assert text.startswith('"""'), package
        assert text.endswith('"""'), package
        assert text.count('"""') == 2, package


def test_pjpdaf_alone_loads_no_simulator_and_a_run_no_statistics():
    code = (
        "import sys, pjpdaf.tracker.filter, pjpdaf.detector.detector, pjpdaf.plugins.registry;"
        "bad = {'mujoco', 'pandas', 'sim', 'reports', 'scenarios'} & set(sys.modules);"
        "assert not bad, bad;"
        # Half a second of every command.
        "import scenarios.run.run; assert 'scipy.stats' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
