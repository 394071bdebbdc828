import os
import re
import subprocess
import sys
import threading

import pytest

from pjpdaf.errors import InfrastructureError
from sim import gl


def having(*libraries):
    return lambda name: name in libraries


def run(code, **environment):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=600,
    )
    return done.stdout.strip(), done.stderr.strip()


@pytest.mark.parametrize(
    ("libraries", "backend"),
    [
        (("libEGL.so.1", "libOpenGL.so.0", "libOSMesa.so.8"), "egl"),
        (("libEGL.so.1", "libGL.so.1"), "egl"),
        (("libEGL.so.1", "libOSMesa.so.8"), "osmesa"),
        (("libOSMesa.so.8",), "osmesa"),
        (("libEGL.so.1",), "disabled"),
        ((), "disabled"),
    ],
)
def test_the_back_end_is_chosen_by_the_libraries_that_load(libraries, backend):
    assert gl.choose({}, having(*libraries)) == backend
    assert gl.choose({"MUJOCO_GL": "on"}, having(*libraries)) == backend


def test_a_value_of_the_user_that_works_is_kept():
    everything = having("libEGL.so.1", "libOpenGL.so.0", "libOSMesa.so.8")
    assert gl.choose({"MUJOCO_GL": "OSMesa "}, everything) == "osmesa"
    assert gl.choose({"MUJOCO_GL": "egl"}, everything) == "egl"
    assert gl.choose({"MUJOCO_GL": "off"}, everything) == "disabled"
    assert gl.choose({"MUJOCO_GL": "glfw", "DISPLAY": ":0"}, everything) == "glfw"


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ({"MUJOCO_GL": "vulkan"}, "MUJOCO_GL=vulkan is no OpenGL back end .choices: egl, osmesa"),
        ({"MUJOCO_GL": "egl"}, "MUJOCO_GL=egl lacks libOpenGL.so.0 or libGL.so.1; apt-get install"),
        ({"MUJOCO_GL": "osmesa"}, "MUJOCO_GL=osmesa lacks libOSMesa.so.8; unset MUJOCO_GL and apt"),
        ({"MUJOCO_GL": "glfw"}, "MUJOCO_GL=glfw needs a display and there is none; unset"),
    ],
)
def test_a_value_of_the_user_that_cannot_work_is_one_line_with_a_remedy(environment, words):
    with pytest.raises(InfrastructureError, match=words) as caught:
        gl.choose(environment, having("libEGL.so.1"))
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 5


def test_importing_the_module_does_not_import_mujoco():
    out, err = run("import sys, sim.gl; print('mujoco' in sys.modules)")
    assert (out, err) == ("False", "")


def test_switched_off_and_broken_values_end_in_our_error_not_in_mujocos():
    code = (
        "from sim import gl\n"
        "from pjpdaf.errors import InfrastructureError\n"
        "try: gl.context()\n"
        "except InfrastructureError as fault: print(fault)\n"
    )
    out, _ = run(code, MUJOCO_GL="disabled")
    assert out == "MUJOCO_GL=disabled switches rendering off; unset it"
    out, _ = run(code, MUJOCO_GL="nonsense")
    assert out.startswith("MUJOCO_GL=nonsense is no OpenGL back end")
    out, _ = run(code, MUJOCO_GL="egl", PYOPENGL_PLATFORM="osmesa")
    assert out == "PYOPENGL_PLATFORM=osmesa contradicts MUJOCO_GL=egl; unset PYOPENGL_PLATFORM"


def test_without_libraries_the_error_names_what_to_install():
    code = (
        "from sim import gl\n"
        "gl.missing.__defaults__ = gl.choose.__defaults__ = (lambda name: False,)\n"
        "from pjpdaf.errors import InfrastructureError\n"
        "print(gl.prepare(), gl.load_mujoco().__name__)\n"
        "try: gl.context()\n"
        "except InfrastructureError as fault: print(fault)\n"
    )
    environment = {k: v for k, v in os.environ.items() if k != "MUJOCO_GL"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=600
    )
    first, second = done.stdout.strip().splitlines()
    assert first == "disabled mujoco"
    assert second.startswith("no offscreen OpenGL here (missing libEGL.so.1, libOpenGL.so.0 or")
    assert second.endswith(gl.REMEDY)


def test_threads_of_the_rasteriser_are_set_only_where_nobody_has(monkeypatch):
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    gl.prepare(threads=0)
    assert os.environ["LP_NUM_THREADS"] == "0"
    gl.prepare(threads=3)
    assert os.environ["LP_NUM_THREADS"] == "0"
    monkeypatch.undo()


def test_describe_names_back_end_and_renderer():
    found = gl.info()
    assert gl.describe() == f"{found.backend}, {found.renderer}, {found.version}"
    assert found.backend == os.environ["MUJOCO_GL"]
    assert found.renderer


def test_a_context_belongs_to_its_thread():
    here = gl.context()
    assert gl.context() is here
    others = []
    thread = threading.Thread(target=lambda: others.append(gl.context()))
    thread.start()
    thread.join()
    assert others[0] is not here
    gl.context()


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ({"PYOPENGL_PLATFORM": "glx"}, "PYOPENGL_PLATFORM=glx contradicts MUJOCO_GL=egl; unset PY"),
        ({gl.DEVICE: "77"}, f"{gl.DEVICE}=77: no OpenGL context .* got 77.*; unset {gl.DEVICE} to"),
        ({gl.DEVICE: "gpu"}, f"{gl.DEVICE}=gpu: .*must be the number of a device, 0 or more"),
    ],
)
def test_a_wrong_setting_is_named_and_no_package_is_asked_for(environment, words):
    _, errors = run("from sim import gl; gl.context()", MUJOCO_GL="egl", **environment)
    line = errors.splitlines()[-1]
    assert line.startswith("pjpdaf.errors.InfrastructureError: ")
    assert re.search(words, line)
    assert "apt-get" not in line
