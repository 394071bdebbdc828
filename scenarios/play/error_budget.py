"""Where the error comes from: the errors of an episode with ever more of the real system in it.

  grid         the exact centres, projected and rounded to whole pixels, then triangulated
  surface      the centroids of the visible skin, triangulated
  detector     the real detections, each given to the target that it shows, triangulated
  filter       the tracker with these detections, their origin known
  association  the tracker as it is

Each level adds one cause; what a level has more than the one before it is that cause's share.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, triangulate, undistort_points
from pjpdaf.interfaces import AnyTracker
from reports.score.records import BUDGET_LEVELS, Episode
from scenarios.play.oracle import Oracle, Seen, stages_of, track_again
from scenarios.play.true_detections import known_targets

Pixels = Callable[[Episode, int, Sequence[Camera]], Floats]  # of a frame: (N, T, 2)


def with_error_budget(
    episode: Episode,
    cameras: Sequence[Camera],
    tracker: AnyTracker,
    seen: Seen | None = None,
    lag: int = 0,
) -> Episode:
    """The episode with the errors of each level of the budget; seen, lag: as `track_again`."""
    return replace(episode, budget_m=error_budget(episode, cameras, tracker, seen, lag))


def error_budget(
    episode: Episode,
    cameras: Sequence[Camera],
    tracker: AnyTracker,
    seen: Seen | None = None,
    lag: int = 0,
) -> Mapping[str, Floats]:
    """Errors (F, T) [m] by level of `BUDGET_LEVELS`, NaN in frames in which any level has no error.

    cameras: the calibration that the tracker was given. Empty for a tracker whose association
    cannot be replaced.
    """
    if "association" not in stages_of(tracker):
        return {}
    centres = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    known = track_again(episode, cameras, tracker, Oracle(association=True), seen, lag)
    located = {
        "grid": _located(episode, cameras, _whole_pixels),
        "surface": _located(episode, cameras, _visible_centroids),
        "detector": _located(episode, cameras, _detections),
        "filter": _estimated(known),
        "association": _estimated(episode),
    }
    errors = {name: np.linalg.norm(points - centres, axis=-1) for name, points in located.items()}
    undefined = np.isnan(np.stack([errors[name] for name in BUDGET_LEVELS])).any(axis=0)
    return {name: np.where(undefined, np.nan, errors[name]) for name in BUDGET_LEVELS}


def _estimated(episode: Episode) -> Floats:
    return np.stack([outcome.estimates.positions_m for outcome in episode.frames])


def _located(episode: Episode, cameras: Sequence[Camera], pixels_of: Pixels) -> Floats:
    """Points (F, T, 3) triangulated from each frame's pixels (N, T, 2); NaN where one is."""
    of_frames = [pixels_of(episode, frame, cameras) for frame in range(len(episode.frames))]
    pixels = np.stack(of_frames, axis=1)  # (N, F, T, 2)
    seen = np.isfinite(pixels).all(axis=(0, 3))
    points = np.full((*seen.shape, 3), np.nan)
    if seen.any():
        points[seen] = triangulate(tuple(cameras), pixels[:, seen])
    return points


def _whole_pixels(episode: Episode, frame: int, cameras: Sequence[Camera]) -> Floats:
    centres = episode.frames[frame].truth.centres_m
    return np.stack([np.rint(project(camera, centres)) for camera in episode.cameras])


def _visible_centroids(episode: Episode, frame: int, cameras: Sequence[Camera]) -> Floats:
    views = episode.frames[frame].truth.views
    marks = []
    for view, camera in zip(views, cameras, strict=True):
        seen = np.isfinite(view.centroids_px).all(axis=1)
        mark = np.full(view.centroids_px.shape, np.nan)
        if seen.any():
            mark[seen] = undistort_points(camera, view.centroids_px[seen])
        marks.append(mark)
    return np.stack(marks)


def _detections(episode: Episode, frame: int, cameras: Sequence[Camera]) -> Floats:
    outcome = episode.frames[frame]
    return known_targets(outcome.truth, outcome.detections, cameras).pixels(outcome.detections)
