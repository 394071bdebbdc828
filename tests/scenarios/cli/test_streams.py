"""Commands whose reader goes away, as in `pjpdaf-bench ... | head`."""

import subprocess

import pytest
from commands import ENVIRONMENT, ROOT, command


def to_nobody(*words):
    """The command with a standard output that nobody reads."""
    with subprocess.Popen(
        command(*words),
        cwd=ROOT,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        process.stdout.close()
        return process.stderr.read().strip(), process.wait(60)


@pytest.mark.sample(1)
@pytest.mark.parametrize("words", [("list",), ("show", "cross")])
def test_a_reader_that_goes_away_is_no_fault(words):
    assert to_nobody("scenarios", *words) == ("", 0)


@pytest.mark.long
def test_a_run_is_saved_though_nobody_reads_its_table(tmp_path):
    out = tmp_path / "run"
    short = ("frames=1", "background_frames=2", "detector.background_learn_min=2")
    settings = [word for setting in short for word in ("--set", setting)]
    said, code = to_nobody("run", "cross", "--seeds", 1, *settings, "--jobs", 1, "--out", out)
    assert (said, code) == ("", 0)
    assert {"run.json", "report.html", "frames.parquet"} <= {f.name for f in out.iterdir()}


def test_exit_codes_stay_though_nobody_reads():
    _, code = to_nobody("run", "crss")
    assert code == 2
