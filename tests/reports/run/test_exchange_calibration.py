"""The example that draws the reliability of stated exchange probabilities."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from reports.run.save import RunInfo, save

EXAMPLE = Path(__file__).parents[3] / "examples/exchange_calibration.py"


def run_example(monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", [EXAMPLE.name, *map(str, words)])
    runpy.run_path(str(EXAMPLE), run_name="__main__")


def test_table_and_diagram_of_saved_runs(episode_of, tools, tmp_path, monkeypatch, capsys):
    episodes = []
    for seed in range(3):
        centres = tools.paths(20, 3.0)
        estimates = centres.copy()
        estimates[:5] = estimates[:5, [0, 2, 1]]
        stated = np.where(np.arange(20) < 5, 0.25, 0.01)
        episodes.append(episode_of(estimates, centres_m=centres, seed=seed, exchange=stated))
    run = save(tmp_path / "run", episodes, RunInfo("run"))
    run_example(monkeypatch, run, "--out", tmp_path / "reliability.svg")
    text = capsys.readouterr().out
    assert "| 0.2 to 0.3 | 15 | 25.00 % | 100.00 % | 100.0 to 100.0 % |" in text
    assert "3 episodes, 60 frames, stated 7.00 %, exchanged 25.00 %" in text
    assert f"expected calibration error {(15 * 0.75 + 45 * 0.01) / 60:.4f}" in text
    assert (tmp_path / "reliability.svg").read_text().startswith("<?xml")


def test_runs_without_a_statement_are_told(episode_of, tmp_path, monkeypatch, capsys):
    run = save(tmp_path / "run", [episode_of()], RunInfo("run"))
    with pytest.raises(SystemExit):
        run_example(monkeypatch, run)
    assert "no frame of these runs has a stated exchange probability" in capsys.readouterr().err
