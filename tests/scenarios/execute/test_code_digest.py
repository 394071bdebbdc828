"""Digests of code: of ours, and of plug-ins, which are not imported."""

import sys

from pjpdaf.plugins.registry import DETECTORS, TRACKERS
from scenarios.execute.code_digest import NO_TRIAL, code_digest, plug_in_digest


def test_digests_of_code():
    assert len(code_digest()) == 64
    assert len(code_digest(NO_TRIAL)) == 64
    assert code_digest(NO_TRIAL) != code_digest()
    assert plug_in_digest("thesis", DETECTORS) == ""
    assert plug_in_digest("no_such_module_at_all:x", TRACKERS) == ""


def test_the_code_of_a_plug_in_counts_and_is_not_run(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "identity_mine.py").write_text("raise RuntimeError('imported')")
    (tmp_path / "identity_package").mkdir()
    for name in ("__init__.py", "deep.py"):
        (tmp_path / "identity_package" / name).write_text("raise RuntimeError('imported')")
    names = ("identity_mine:make", "identity_package.deep:make")
    before = [plug_in_digest(name, TRACKERS) for name in names]
    assert len({*before, ""}) == 3
    (tmp_path / "identity_mine.py").write_text("another")
    (tmp_path / "identity_package" / "deep.py").write_text("another")
    after = [plug_in_digest(name, TRACKERS) for name in names]
    assert not {*before} & {*after}
    assert not {"identity_mine", "identity_package"} & sys.modules.keys()
    assert plug_in_digest("thesis", TRACKERS) == plug_in_digest("no_such_module:x", TRACKERS) == ""
