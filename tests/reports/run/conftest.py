"""Saved runs of a few synthetic episodes."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure, OverlayPicture, Still

INFO = RunInfo("night", preset="default", overrides={"gate": 15.0}, argv=("run", "calm_table"))


@pytest.fixture(scope="session")
def played(episode_of, tools):
    episodes = []
    for scenario in ("calm_table", "cross"):
        for seed in range(3):
            centres = tools.paths(12, 3.0)
            estimates = tools.noisy(centres, seed)
            if scenario == "cross" and seed == 1:
                estimates[5:] = estimates[5:][:, [0, 2, 1]]
            picture = OverlayPicture(3, b"\xff\xd8jpeg")
            episodes.append(
                replace(
                    episode_of(
                        estimates,
                        centres_m=centres,
                        scenario=scenario,
                        seed=seed,
                        pictures=(picture,),
                    ),
                    film=tuple(Still(f, f"RIFF {seed} {f}".encode()) for f in (0, 3, 11)),
                )
            )
    return [*episodes, EpisodeFailure("cross", 3, "timed out", group="hand and hand")]


@pytest.fixture(scope="session")
def saved(played, tmp_path_factory):
    return save(tmp_path_factory.mktemp("saved") / "night", played, INFO)


@pytest.fixture
def run(saved, tmp_path):
    """A copy of the saved run, to be changed."""
    return Path(shutil.copytree(saved, tmp_path / "night"))


@pytest.fixture(scope="session")
def info():
    return INFO
