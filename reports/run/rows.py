"""An episode as rows of a saved run's tables, small enough to pass between processes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pjpdaf.targets import TARGETS
from reports.run.episode_rows import camera_rows, episode_rows, event_rows, failed_row, tracking_row
from reports.run.frame_columns import detection_columns, frame_columns
from reports.run.motion_mark import motion_mark
from reports.run.schema import FRAMES, TableRow
from reports.score.records import (
    STAGES,
    Episode,
    EpisodeFailure,
    FailureKind,
    OverlayPicture,
    Still,
)
from reports.score.score import score


@dataclass(frozen=True, eq=False)
class EpisodeRows:
    """The rows that a run keeps of one episode.

    frames, detections: columns of `FRAMES` and `DETECTIONS`; episodes: the three rows of
    `EPISODES`; events, cameras: rows of `EVENTS` and `CAMERAS`; tracking: the row of `TRACKING`,
    None for an episode without a result. stage_s: wall time of a stage summed over the frames [s],
    in no table. truth: `motion_mark` of the true positions. renderer, replayed,
    detections_kept: as of `Episode`.
    """

    scenario: str
    seed: int
    digest: str
    frames: Mapping[str, list[object]]
    episodes: tuple[TableRow, ...]
    events: tuple[TableRow, ...]
    pictures: tuple[OverlayPicture, ...]
    stage_s: Mapping[str, float]
    frame_count: int
    failure: str = ""
    failure_kind: FailureKind | None = None
    tracking: TableRow | None = None
    truth: str = ""
    detections: Mapping[str, list[object]] = field(default_factory=dict)
    cameras: tuple[TableRow, ...] = ()
    film: tuple[Still, ...] = ()
    renderer: str = ""
    replayed: bool = False
    detections_kept: bool = False


def rows_of(played: Episode | EpisodeFailure) -> EpisodeRows:
    """Score an episode. A failure has three rows of `EPISODES` and no frames."""
    if isinstance(played, EpisodeFailure):
        return EpisodeRows(
            scenario=played.scenario,
            seed=played.seed,
            digest=played.digest,
            frames={name: [] for name in FRAMES.names},
            episodes=tuple(failed_row(played, target) for target in TARGETS),
            events=(),
            pictures=(),
            stage_s={},
            frame_count=0,
            failure=played.reason or "unknown",
            failure_kind=played.kind,
        )
    result = score(played)
    stages = sorted({*STAGES, *(name for o in played.frames for name in o.stage_s)})
    return EpisodeRows(
        scenario=played.scenario,
        seed=played.seed,
        digest=played.digest,
        frames=frame_columns(played, result),
        episodes=episode_rows(played, result),
        events=event_rows(played),
        pictures=played.pictures,
        stage_s={s: sum(o.stage_s.get(s, 0.0) for o in played.frames) for s in stages},
        frame_count=len(played.frames),
        tracking=tracking_row(played),
        truth=motion_mark(np.stack([o.truth.centres_m for o in played.frames])),
        detections=detection_columns(played),
        cameras=camera_rows(played),
        film=played.film,
        renderer=played.renderer,
        replayed=played.replayed,
        detections_kept=played.detections_kept,
    )
