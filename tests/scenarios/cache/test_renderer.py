"""The renderer is remembered as long as nothing that chooses it has changed."""

import os

from scenarios.cache import renderer
from scenarios.cache.renderer import MEMO, fingerprint, known_renderer, remember

NAME = "egl, llvmpipe"


def test_it_is_remembered(tmp_path):
    assert known_renderer(tmp_path) is None
    remember(tmp_path, NAME)
    assert known_renderer(tmp_path) == NAME
    remember(tmp_path, "another")
    assert known_renderer(tmp_path) == "another"


def test_other_variables_ask_again(tmp_path, monkeypatch):
    remember(tmp_path, NAME)
    for name, value in (
        ("MUJOCO_GL", "disabled"),
        ("GALLIUM_DRIVER", "softpipe"),
        ("LD_LIBRARY_PATH", "/opt/mesa"),
        ("MUJOCO_EGL_DEVICE_ID", "1"),
    ):
        with monkeypatch.context() as patch:
            patch.setenv(name, value)
            assert known_renderer(tmp_path) is None, name
    assert known_renderer(tmp_path) == NAME
    # That the back end was chosen is no change: `gl.prepare` writes it into the environment.
    backend = renderer.gl.choose(os.environ)
    plain = {k: v for k, v in os.environ.items() if k != "MUJOCO_GL"}
    if renderer.gl.choose(plain) == backend:
        assert fingerprint(plain) == fingerprint({**plain, "MUJOCO_GL": backend})


def test_a_library_installed_anew_asks_again(tmp_path, monkeypatch):
    libraries = tmp_path / "ld.so.cache"
    libraries.write_text("one")
    monkeypatch.setattr(renderer, "LINKER_LISTS", (libraries,))
    remember(tmp_path, NAME)
    assert known_renderer(tmp_path) == NAME
    os.utime(libraries, (1, 1))
    assert known_renderer(tmp_path) is None
    libraries.unlink()
    assert fingerprint() is None
    remember(tmp_path, NAME)
    assert known_renderer(tmp_path) is None


def test_a_damaged_or_strange_memory_is_none(tmp_path):
    for content in ("", "{", "[]", '{"a": 1}', "[" * 100_000, '{"x": "' + "y" * 1000 + '"}'):
        (tmp_path / MEMO).write_text(content)
        assert known_renderer(tmp_path) is None
    remember(tmp_path, NAME)
    assert known_renderer(tmp_path) == NAME


def test_a_folder_that_cannot_be_written_remembers_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    remember(tmp_path / "file" / "cache", NAME)
    assert known_renderer(tmp_path / "file" / "cache") is None
