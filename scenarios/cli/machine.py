"""What the verb `doctor` examines: Python, packages, OpenGL, the self-test."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import sys
from dataclasses import dataclass

from pjpdaf.errors import InfrastructureError

PACKAGES = (
    "mujoco",
    "mujoco-core",
    "numpy",
    "opencv-python-headless",
    "scipy",
    "pandas",
    "pyarrow",
)


@dataclass(frozen=True)
class Finding:
    """The state of a component; remedy is empty where it is good."""

    component: str
    good: bool
    state: str
    remedy: str = ""


def examine_machine() -> list[Finding]:
    """Examine Python, packages, OpenGL and the geometry of a rendered picture."""
    return [_python(), *(_package(name) for name in PACKAGES), _one_opencv(), *_rendering()]


def _python() -> Finding:
    good, cores = sys.version_info >= (3, 11), os.cpu_count()
    remedy = "" if good else "install Python 3.11 or newer"
    listed = "1 core" if cores == 1 else f"{cores} cores"
    state = f"{platform.python_version()} on {platform.platform()}, {listed}"
    return Finding("Python", good, state, remedy)


def _package(name: str) -> Finding:
    try:
        return Finding(name, True, importlib.metadata.version(name))
    except importlib.metadata.PackageNotFoundError:
        return Finding(name, False, "not installed", f"pip install {name}")


def _one_opencv() -> Finding:
    # Both wheels write the same folder cv2: whichever came last wins, and removing one breaks both.
    others = []
    for name in ("opencv-python", "opencv-contrib-python", "opencv-contrib-python-headless"):
        try:
            others.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            continue
    if not others:
        return Finding("one OpenCV", True, "the headless wheel alone")
    remedy = (
        f"pip uninstall {others[0].split()[0]}; "
        "pip install --force-reinstall --no-deps opencv-python-headless"
    )
    return Finding("one OpenCV", False, ", ".join(others) + " beside the headless wheel", remedy)


def _rendering() -> list[Finding]:
    from sim.processes import check_renderer

    asked = os.environ.get("MUJOCO_GL")
    setting = Finding("MUJOCO_GL", True, asked if asked else "not set (chosen by probing)")
    try:
        renderer = check_renderer()
    except InfrastructureError as fault:
        return [setting, Finding("offscreen OpenGL", False, fault.cause, fault.remedy)]
    return [
        setting,
        Finding("offscreen OpenGL", True, renderer),
        Finding("self-test", True, "a rendered sphere is where the camera says"),
    ]
