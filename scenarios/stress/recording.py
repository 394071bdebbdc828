"""Episodes that the page plays: trials played again, with a film, as a saved run."""

from __future__ import annotations

import importlib
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace

from reports.pictures.silhouettes import silhouette_still
from reports.pictures.stills import VIEW_WIDTH_PX
from reports.run.rows import EpisodeRows, rows_of
from reports.run.save import RunInfo, save
from reports.score.records import Episode, Still
from reports.stress.records import EpisodeKey
from scenarios.play.job import Job
from scenarios.play.play import play_complete
from scenarios.spec.draw import unjudged
from scenarios.stress.campaign import Campaign
from scenarios.stress.case import Trial
from sim.processes import Answer
from sim.silhouettes.film import film_of
from sim.silhouettes.painter import Painter


@dataclass(frozen=True)
class Shown:
    """A trial to show, and the label of its episode, which is unique with the seed."""

    label: str
    trial: Trial

    @property
    def key(self) -> EpisodeKey:
        """Where the page finds it."""
        return EpisodeKey(label=self.label, seed=self.trial.case.seed)


def record_episodes(campaign: Campaign, shown: Sequence[Shown], name: str) -> None:
    """Play trials again and save them in the campaign's folder `name`, in place of what is there.

    A fast trial has painted silhouettes for a film, a full one its pictures and the stages to
    blame. A trial that gives no result now is left out. Without any, nothing is written. Raises
    BenchError.
    """
    if not shown:
        return
    campaign.progress.start("episodes of the page", len(shown))
    rows: dict[int, EpisodeRows] = {}
    tasks = dict(enumerate(shown))
    runner = campaign.runner
    for indexed in runner.executor.outcomes(_recorded, tasks, runner.time_limit_s):
        if indexed is None:
            continue
        index, outcome = indexed
        if isinstance(outcome, Answer) and isinstance(outcome.value, EpisodeRows):
            rows[index] = outcome.value
        campaign.progress.meter.finish(1)
    path = campaign.folder / name
    if (path / "run.json").is_file():
        shutil.rmtree(path)
    system = shown[0].trial.system
    info = RunInfo(name=name, detector=system.detector, tracker=system.tracker)
    save(path, [rows[i] for i in sorted(rows)], info)


def _recorded(shown: Shown) -> EpisodeRows | None:
    """The rows of an episode; None where it cannot be played."""
    try:
        job = shown.trial.case.job(shown.trial.system, label=shown.label, film=True)
        if shown.trial.fidelity == "full":
            return rows_of(play_complete(job))
        return rows_of(_with_silhouettes(job))
    except (Exception, SystemExit):  # of a plug-in, too
        return None


def _with_silhouettes(job: Job) -> Episode:
    episode: Episode = importlib.import_module("scenarios.play.fast").play_fast(job)
    performance = unjudged(job.scenario, job.seed, job.overrides, 0)
    step_px = max(1, min(c.width_px for c in episode.cameras) // VIEW_WIDTH_PX)
    painter = Painter(film_of(performance, step_px, everything=True))
    film = tuple(
        Still(i, silhouette_still([view.classes for view in painter.paint(i)]))
        for i in range(len(episode.frames))
    )
    return replace(episode, film=film)
