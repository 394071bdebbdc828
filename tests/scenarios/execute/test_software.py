"""The software that decides results, and how it differs from that of another process."""

import os
import sys

from scenarios.execute.software import OUR_CODE, PlugIns, differences, software
from scenarios.spec.motion.plugged import TRUSTED_VARIABLE


def test_plug_ins_are_what_is_no_preset(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert PlugIns.named("default", "thesis") == PlugIns()
    assert PlugIns.named(None, "mine:make") == PlugIns((), ("mine:make",), str(tmp_path))
    assert PlugIns.named("entry", "default") == PlugIns(("entry",))


def test_the_code_of_a_plug_in_counts(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "my_software_tracker.py").write_text("a = 1\n")
    plug_ins = PlugIns((), ("my_software_tracker:make",), str(tmp_path))
    here = software(plug_ins)
    assert len(here["tracker 'my_software_tracker:make'"]) == 64
    assert sys.path[-1] == str(tmp_path)
    without = software(PlugIns((), ("not_there:make",)))
    assert without["tracker 'not_there:make'"] == ""


def test_differences_name_both_versions():
    ours = {OUR_CODE: "a" * 64, "numpy": "2.4.1", "tracker 'x:y'": "c" * 64}
    assert differences(ours, ours) == ""
    theirs = {OUR_CODE: "b" * 64, "numpy": "2.4.0"}
    assert differences(theirs, ours) == (
        "the code of pjpdaf-bench bbbbbbbb, here aaaaaaaa; numpy 2.4.0, here 2.4.1; "
        "tracker 'x:y' missing, here cccccccc"
    )


def test_motions_of_plug_ins_count_and_are_trusted(tmp_path, monkeypatch):
    (tmp_path / "knocks.py").write_text("")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    monkeypatch.setenv(TRUSTED_VARIABLE, "")
    needed = PlugIns.named("default", "default").with_motions(["knocks:make", "knocks:make"])
    assert needed == PlugIns(folder=str(tmp_path), motions=("knocks:make",))
    first = software(needed)["motion 'knocks:make'"]
    assert len(first) == 64
    assert os.environ[TRUSTED_VARIABLE] == "knocks:make"
    software.cache_clear()
    (tmp_path / "knocks.py").write_text("# another")
    assert software(needed)["motion 'knocks:make'"] != first
    software.cache_clear()
