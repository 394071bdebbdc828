"""The command as users start it: real processes, real exit codes, one line a fault."""

import os
import re
import subprocess
import sys

import pytest
from commands import ROOT, assert_one_line, bench, in_this_process


@pytest.mark.parametrize(
    ("words", "fragments"),
    [
        (("run", "dirnk"), ("dirnk", "did you mean drink?")),
        (("run", "--preset", "thesiss"), ("thesiss", "Did you mean 'thesis'?")),
        (("run", "cross", "--set", "speeed=0.3"), ("speeed", "did you mean speed?")),
        (("run", "cross", "--set", "speed=9"), ("speed", "9", "0.1 to 0.6 m/s")),
        (("run", "cross", "--set", "speed=3 kg"), ("speed", "m/s", "kg")),
        (("run", "cross", "--set", "speed"), ("KEY=VALUE",)),
        (("run", "cross", "--set", "speed=.2", "--set", "speed=.3"), ("speed", "twice")),
        (
            ("run", "cross", "--preset", "thesis", "--set", "tracker.p_detekt=.5"),
            ("p_detekt", "p_detect"),
        ),
        (("run", "cross", "--preset", "thesis", "--set", "tracker.p_detect=2"), ("p_detect", "2")),
        (("run", "cross", "cross"), ("cross", "twice")),
        (("run", "--seeds", "0"), ("--seeds", "0")),
        (("run", "--seeds", "-3"), ("--seeds", "-3")),
        (("run", "--jobs", "0"), ("--jobs", "0")),
        (("run", "--jobs", "-2"), ("--jobs", "-2")),
        (("run", "--jobs", "1000000"), ("--jobs", "1000000")),
        (("run", "--tracker", "nowhere:make"), ("nowhere",)),
        (("run", "missing.yaml"), ("missing.yaml",)),
        (("report", "nowhere"), ("nowhere", "no such run")),
        (
            ("track", "--left", "l", "--out", "o", "--calibration", "c.yml", "--no-background"),
            ("--calibration takes two files", "the option --no-background"),
        ),
        (("scenarios", "show", "crss"), ("crss", "did you mean cross?")),
    ],
    ids=lambda value: "-".join(value)[:40],
)
def test_bad_input_is_one_line_and_exit_code_2(words, fragments):
    assert_one_line(in_this_process(*words), 2, *fragments)


def test_a_process_of_its_own_says_the_same():
    assert_one_line(bench("run", "dirnk"), 2, "dirnk", "did you mean drink?")


def test_a_fault_in_a_yaml_file_has_line_and_column(tmp_path):
    text = (ROOT / "scenarios/catalog/cross.yaml").read_text()
    file = tmp_path / "mine.yaml"
    file.write_text(text.replace("frames: 54", "framez: 48"))
    line = text[: text.index("frames: 54")].count("\n") + 1
    done = in_this_process("run", file)
    assert_one_line(done, 2, f"mine.yaml:{line}:1: framez: no such field; did you mean frames?")


def test_an_existing_folder_is_not_overwritten(tmp_path):
    (tmp_path / "keep").write_text("mine")
    done = in_this_process("run", "cross", "--out", tmp_path)
    assert_one_line(done, 2, str(tmp_path), "not empty")
    assert (tmp_path / "keep").read_text() == "mine"


def test_a_file_as_output_folder(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    done = in_this_process("run", "cross", "--out", file)
    assert_one_line(done, 2, "file")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder(tmp_path):
    tmp_path.chmod(0o555)
    assert_one_line(bench("run", "cross", "--out", tmp_path / "run"), 2, "not writable")


@pytest.mark.parametrize("value", ["potato", "glfw", "egl2"])
def test_a_broken_mujoco_gl_is_one_line_and_exit_code_5(value, tmp_path, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", value)  # of the worker, which renders
    done = in_this_process("run", "cross", "--seeds", "1", "--out", tmp_path / "run")
    assert_one_line(done, 5, "MUJOCO_GL", value)


def test_help_loads_nothing_heavy():
    code = (
        "import sys; import scenarios.cli.main;"
        "heavy = {'numpy', 'cv2', 'mujoco', 'pandas', 'scipy', 'pydantic'};"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
    helped = bench("run", "--help")
    assert helped.returncode == 0
    for option in ("--seeds", "--preset", "--detector", "--tracker", "--set", "--jobs", "--out"):
        assert option in helped.stdout


def test_an_unforeseen_fault_is_one_line_and_no_verdict(monkeypatch, tmp_path):
    def broken(*arguments):
        raise KeyError("a\x1bb")

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("reports.run.load._load_meta", broken)
    assert_one_line(
        in_this_process("report", "run", "--out", tmp_path / "x.html"), 5, "KeyError", "--debug"
    )
    shown = in_this_process("report", "run", "--out", tmp_path / "x.html", "--debug")
    assert "in broken" in shown.stderr
    assert "\x1b" not in shown.stderr


VERBS = ((), ("run",), ("stress",), ("stress", "all", "map"), ("dataset",), ("dataset", "make"))


@pytest.mark.parametrize("columns", [30, 45, 60, 80, 120])
@pytest.mark.parametrize("words", VERBS)
def test_help_is_whole_at_any_width(words, columns, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    lines = in_this_process(*words, "--help").stdout.splitlines()
    below = lines[lines.index("") :]  # the usage names the program, which is pytest here
    assert max(map(len, below)) <= columns
    assert not [line for line in below if re.search(r"(\.\.\.|\u2026|\w-)$", line)]
