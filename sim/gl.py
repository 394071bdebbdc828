"""The OpenGL back end: chosen before mujoco is imported, and one context per thread.

MuJoCo reads MUJOCO_GL when it is imported and fails there without a word about the cause, so
nothing may import it before `prepare` has run: use `load_mujoco`.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import os
import platform
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from pjpdaf.errors import InfrastructureError

REMEDY = "apt-get install --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri"
OFF = ("disable", "disabled", "off", "false", "0")  # MuJoCo's own words for "do not render"
ON = ("", "enable", "enabled", "on", "true", "1")  # its words for "choose a back end"
# Of every group of a back end, one library must load.
LIBRARIES: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "egl": (("libEGL.so.1",), ("libOpenGL.so.0", "libGL.so.1")),
    "osmesa": (("libOSMesa.so.8",),),
}
DEVICE = "MUJOCO_EGL_DEVICE_ID"  # of MuJoCo: which graphics card
CHOICES = ("egl", "osmesa", "glfw", "glx", "disabled")

_local = threading.local()


@dataclass(frozen=True)
class GLInfo:
    """The renderer: MuJoCo's back end, GL_RENDERER and GL_VERSION (which names Mesa's version)."""

    backend: str
    renderer: str
    version: str

    def __str__(self) -> str:
        return f"{self.backend}, {self.renderer}, {self.version}"


def loads(library: str) -> bool:
    """Whether the dynamic linker finds and loads this library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def missing(backend: str, probe: Callable[[str], bool] = loads) -> tuple[str, ...]:
    """Libraries that a back end lacks, 'libA or libB' per group; () where it is complete."""
    groups = LIBRARIES.get(backend, ())
    return tuple(" or ".join(group) for group in groups if not any(map(probe, group)))


def choose(environment: Mapping[str, str], probe: Callable[[str], bool] = loads) -> str:
    """The back end for this environment: the user's MUJOCO_GL, else EGL, OSMesa, `disabled`.

    Raises InfrastructureError where the user's value cannot work.
    """
    asked = environment.get("MUJOCO_GL", "").strip().lower()
    if asked in ON:
        usable = [name for name in LIBRARIES if not missing(name, probe)]
        return usable[0] if usable else "disabled"
    if asked in OFF:
        return "disabled"
    if asked not in CHOICES:
        raise InfrastructureError(
            f"MUJOCO_GL={asked} is no OpenGL back end (choices: {', '.join(CHOICES)})",
            "unset MUJOCO_GL to have one chosen",
        )
    if asked in ("glfw", "glx") and not (
        environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")
    ):
        raise InfrastructureError(
            f"MUJOCO_GL={asked} needs a display and there is none",
            "unset MUJOCO_GL and " + REMEDY,
        )
    lacking = missing(asked, probe)
    if lacking:
        remedy = REMEDY if asked == "egl" else "unset MUJOCO_GL and " + REMEDY
        raise InfrastructureError(f"MUJOCO_GL={asked} lacks {', '.join(lacking)}", remedy)
    return asked


def prepare(threads: int | None = None) -> str:
    """Set MUJOCO_GL, and the rasteriser's threads if given; returns the back end.

    threads: LP_NUM_THREADS of Mesa's llvmpipe, 0 for a process per core; a value in the environment
    wins. Call before the first import of mujoco and before the first GL call.
    Raises InfrastructureError where a back end asked for by the user cannot work.
    """
    if threads is not None:
        os.environ.setdefault("LP_NUM_THREADS", str(threads))
    if platform.system() != "Linux":
        return os.environ.get("MUJOCO_GL", "native")  # MuJoCo's default works there
    if "mujoco" in sys.modules and not os.environ.get("MUJOCO_GL"):
        raise InfrastructureError(
            "mujoco was imported before its OpenGL back end was chosen; "
            "import sim before mujoco, or set MUJOCO_GL=egl"
        )
    backend = choose(os.environ)
    check_platform(backend, os.environ)
    os.environ["MUJOCO_GL"] = backend
    return backend


def check_platform(backend: str, environment: Mapping[str, str]) -> None:
    """Raise InfrastructureError where PYOPENGL_PLATFORM is another back end's than MuJoCo's."""
    platform_name = environment.get("PYOPENGL_PLATFORM", "")
    if backend in LIBRARIES and platform_name and platform_name.lower() != backend:
        raise InfrastructureError(
            f"PYOPENGL_PLATFORM={platform_name} contradicts MUJOCO_GL={backend}",
            "unset PYOPENGL_PLATFORM",
        )


@functools.cache
def load_mujoco() -> Any:
    """The module mujoco, imported with a back end that works.

    Raises InfrastructureError where the back end cannot be loaded.
    """
    backend = prepare()
    try:
        return importlib.import_module("mujoco")
    except (AttributeError, ImportError, OSError, RuntimeError) as fault:
        cause = str(fault).partition("\n")[0]
        raise InfrastructureError(
            f"mujoco cannot be imported with MUJOCO_GL={backend} ({cause})", REMEDY
        ) from fault


def context() -> Any:
    """This thread's GL context, created at the first call, and made current.

    It lives as long as the process: contexts leak, and switching between them corrupts. Raises
    InfrastructureError where a context cannot be made, or in a process that was forked after
    rendering.
    """
    pid = os.getpid()
    owner = getattr(_local, "pid", pid)
    if owner != pid:
        raise InfrastructureError(
            "this process was forked after rendering had begun", "start workers by spawn"
        )
    held = getattr(_local, "context", None)
    if held is None:
        held = _create_context()
        _local.context, _local.pid = held, pid
    held.make_current()
    return held


@functools.cache
def functions() -> SimpleNamespace:
    """OpenGL's functions and constants by name, up to 3.0; needs a context only when called.

    From the modules of the versions: to import all of OpenGL.GL takes five times as long.
    """
    load_mujoco()  # sets the platform that PyOpenGL takes
    names: dict[str, Any] = {}
    for version in ("1_0", "1_1", "1_3", "2_0", "3_0"):
        names |= vars(importlib.import_module(f"OpenGL.raw.GL.VERSION.GL_{version}"))
    return SimpleNamespace(**{k: v for k, v in names.items() if k.lower().startswith("gl")})


def _create_context() -> Any:
    if prepare() == "disabled":
        lacking = [", ".join(missing(name)) for name in LIBRARIES]
        if not all(lacking):
            raise InfrastructureError("MUJOCO_GL=disabled switches rendering off", "unset it")
        raise InfrastructureError(
            f"no offscreen OpenGL here (missing {', and '.join(lacking)})", REMEDY
        )
    load_mujoco()
    module = importlib.import_module("mujoco.gl_context")
    try:
        # The size matters to OSMesa only, which draws into its own frame buffer besides.
        return module.GLContext(64, 64)
    except Exception as fault:  # PyOpenGL raises a different class for each driver fault
        cause = str(fault).strip().partition("\n")[0]
        raise _no_context(cause, os.environ) from fault


def _no_context(cause: str, environment: Mapping[str, str]) -> InfrastructureError:
    """The fault of a context that cannot be made; it names a device that the user chose."""
    device = environment.get(DEVICE)
    if device is None:
        return InfrastructureError(f"no OpenGL context ({cause})", REMEDY)
    if not device.strip().isdecimal():
        cause = "must be the number of a device, 0 or more"
    return InfrastructureError(
        f"{DEVICE}={device}: no OpenGL context on this device ({cause})",
        f"unset {DEVICE} to have a device chosen",
    )


def info() -> GLInfo:
    """The renderer of this thread. Raises InfrastructureError where no context can be made."""
    context()
    GL = importlib.import_module("OpenGL.GL")
    renderer, version = (GL.glGetString(name) for name in (GL.GL_RENDERER, GL.GL_VERSION))
    return GLInfo(os.environ.get("MUJOCO_GL", "native"), renderer.decode(), version.decode())


def describe() -> str:
    """The renderer in one line. Raises InfrastructureError where there is none."""
    return str(info())


if __name__ == "__main__":  # asked by the wrapper `bench`: does OpenGL render here?
    try:
        print(describe())
    except InfrastructureError as fault:
        sys.exit(str(fault))
