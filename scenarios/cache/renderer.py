"""Which OpenGL renderer draws here: remembered, so that replayed footage needs no OpenGL.

To ask OpenGL costs a context and a second of CPU. The answer is kept in the cache's folder, by a
fingerprint of what chooses the renderer: variables, the machine's boot, the linker's list of
libraries, which every installation of a library writes anew.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path

from pjpdaf.errors import BenchError, InfrastructureError
from sim import gl
from sim.files import written_whole_file

MEMO = "renderers.json"
MOST_MEMOS, MOST_BYTES, MOST_TEXT = 16, 1 << 16, 300
LINKER_LISTS = (Path("/etc/ld.so.cache"), Path("/usr/share/glvnd/egl_vendor.d"))
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
# Not PYOPENGL_PLATFORM: MuJoCo overwrites it.
VARIABLES = (
    *("MUJOCO_EGL_", "LIBGL_", "MESA_", "GALLIUM_", "EGL_", "__EGL_", "__GL", "DRI_", "LP_NATIVE_"),
    *("LD_", "DISPLAY", "WAYLAND_", "CUDA_VISIBLE_", "NVIDIA_"),
)


def known_renderer(folder: Path) -> str | None:
    """The renderer that was asked before, in the same circumstances; None where none was."""
    return _memos(folder).get(fingerprint() or "")


def asked_renderer(folder: Path) -> str | None:
    """The renderer of this process, asked of OpenGL and remembered; None without OpenGL."""
    try:
        gl.prepare()
        renderer = gl.describe()
    except InfrastructureError:
        return None
    remember(folder, renderer)
    return renderer


def remember(folder: Path, renderer: str) -> None:
    """Keep the renderer of these circumstances; where the disk refuses, it is asked again."""
    mark, memos = fingerprint(), _memos(folder)
    if mark is None or memos.get(mark) == renderer:
        return
    kept = {key: value for key, value in memos.items() if key != mark}
    kept = {**dict(list(kept.items())[1 - MOST_MEMOS :]), mark: renderer}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with written_whole_file(folder / MEMO, "the renderer", replace=True) as part:
            part.write_text(json.dumps(kept, indent=1), encoding="utf-8")
    except (BenchError, OSError):
        return


def fingerprint(environment: Mapping[str, str] = os.environ) -> str | None:
    """What chooses the renderer, as a digest; None on a system that does not say."""
    chosen = sorted((k, v) for k, v in environment.items() if k.startswith(VARIABLES))
    try:
        # What MUJOCO_GL comes to: `gl.prepare` writes that into the environment.
        chosen.append(("back end", gl.choose(environment)))
        lists = [LINKER_LISTS[0].stat()]
        lists += [path.stat() for path in LINKER_LISTS[1:] if path.exists()]
        boot = BOOT_ID.read_text(encoding="utf-8")
    except (InfrastructureError, OSError):
        return None
    marks = [(s.st_dev, s.st_ino, s.st_size, s.st_mtime_ns) for s in lists]
    return hashlib.sha256(repr((chosen, marks, boot)).encode()).hexdigest()


def _memos(folder: Path) -> dict[str, str]:
    """Renderers by fingerprint; of a damaged file none."""
    try:
        with (folder / MEMO).open("rb") as file:
            record = json.loads(file.read(MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(record, dict):
        return {}
    return {k: v for k, v in record.items() if isinstance(v, str) and len(v) <= MOST_TEXT}
