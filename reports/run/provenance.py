"""Provenance of results: versions, machine, commit."""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from collections.abc import Sequence
from pathlib import Path

PACKAGES = (
    "pjpdaf-bench",
    "mujoco",
    "numpy",
    "opencv-python-headless",
    "scipy",
    "pandas",
    "pyarrow",
    "pydantic",
)


def provenance(argv: Sequence[str] = (), renderer: str = "") -> dict[str, object]:
    """Plain values for `run.json`.

    renderer: the OpenGL renderer string; argv: the words of the command.
    """
    commit, dirty = _commit(Path(__file__).resolve().parent)
    return {
        "versions": versions(),
        "platform": f"{platform.system()} {platform.machine()}",
        "cpu": _cpu(),
        "renderer": renderer,
        "commit": commit,
        "dirty": dirty,
        "argv": list(argv),
    }


def versions() -> dict[str, str]:
    """Versions of Python and of the packages on which results depend."""
    return {"python": platform.python_version(), **package_versions()}


def package_versions(names: Sequence[str] = PACKAGES) -> dict[str, str]:
    """Versions of packages, as far as they are installed."""
    found = {}
    for name in names:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def _cpu() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"


def _commit(folder: Path) -> tuple[str | None, bool | None]:
    """Commit of the checkout that tracks this file, and whether it has changes; else None."""
    try:
        _git(folder, "ls-files", "--error-unmatch", Path(__file__).name)
        commit = _git(folder, "rev-parse", "HEAD")
        return commit, bool(_git(folder, "status", "--porcelain", "--untracked-files=no"))
    except (OSError, subprocess.SubprocessError):
        return None, None


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        ["git", "--no-optional-locks", *arguments],
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
        timeout=10,
    )
    return done.stdout.strip()
