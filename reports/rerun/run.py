"""A saved run as a recording for the Rerun viewer: cameras, films, paths, errors and events."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError
from reports.page.episode_tables import episode_tables
from reports.rerun.recording import Entities, check_suffix, identity_of, write_recording
from reports.rerun.run_entities import log_episode
from reports.run.load import SavedRun, read_film
from reports.score.records import VIEWS


def write_rerun(run: SavedRun, file: Path) -> Path:
    """Write all episodes with a result into one new `file` (.rrd) and return it.

    Entities are scenario/seed/..., on the timelines `frame` and `time`; all lengths in metres, the
    world of the simulator (x towards the cameras, y to the person's left, z up), pixels of the
    undistorted pictures. Equal runs give equal content but for Rerun's chunk and row ids and the
    order of its chunks.

    Raises as `write_recording`, and BenchError where the run has nothing to show.
    """
    check_suffix(file)
    if run.slim:
        raise BenchError(f"{run.folder}: is a slim run, without frames; there is nothing to show.")
    if run.frames.empty:
        raise BenchError(f"{run.folder}: no episode has a result; there is nothing to show.")

    def log_all(rr: Any, blueprint: Any, stream: Any) -> Any:
        films = {(film["scenario"], int(film["seed"])): film["file"] for film in run.meta["films"]}
        views: dict[str, list[Any]] = {}
        for episode in episode_tables(run):
            entities = Entities(rr, stream, (episode.scenario, str(episode.seed)))
            film = films.get((episode.scenario, episode.seed))
            log_episode(entities, episode, read_film(run, film) if film else {})
            views.setdefault(episode.scenario, []).append(
                _layout(blueprint, entities, f"seed {episode.seed}")
            )
        tabs = blueprint.Tabs
        return tabs(*[tabs(*seeds, name=name) for name, seeds in views.items()])

    return write_recording(file, run.name, recording_id(run), log_all)


def recording_id(run: SavedRun) -> str:
    """An id that equal runs share."""
    return identity_of(run.meta["files"])


def _layout(rrb: Any, entities: Entities, name: str) -> Any:
    """The views of one episode. rrb: the package `rerun.blueprint`."""
    moving = [f"{entities.path(kind)}/**" for kind in ("truth", "estimate", "trail")]
    pictures = [
        rrb.Spatial2DView(
            origin=entities.path("cameras", view), contents=["$origin/**", *moving], name=view
        )
        for view in VIEWS
    ]
    return rrb.Horizontal(
        rrb.Vertical(
            rrb.Spatial3DView(origin=entities.path(), name="3-D"), rrb.Horizontal(*pictures)
        ),
        rrb.Vertical(
            rrb.TimeSeriesView(origin=entities.path("error_mm"), name="error [mm]"),
            rrb.TimeSeriesView(origin=entities.path("err_acc_px"), name="accuracy error [px]"),
            rrb.TextLogView(
                origin=entities.path(),
                contents=[entities.path("events"), entities.path("labels")],
                name="events",
            ),
        ),
        column_shares=[3, 2],
        name=name,
    )
