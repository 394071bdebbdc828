"""The entities of one episode in a recording for the Rerun viewer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.targets import TARGETS
from reports.page.episode_tables import EpisodeTables
from reports.pictures.encode import jpeg_of, picture_of
from reports.pictures.overlay import LETTERS, ellipse_points
from reports.pictures.stills import VIEW_WIDTH_PX
from reports.rerun.recording import CORNER_PX, QUALITY, TARGET_RGB, Entities
from reports.words import LABELS, event_text

TRAIL_S = 2.0
SIGMAS = 2.0  # half axes of the ellipsoids
TRUTH_RGB = ((156, 95, 66), (49, 128, 106), (72, 124, 166))
DETECTION_RGB = (255, 225, 60)


def log_episode(entities: Entities, episode: EpisodeTables, film: Mapping[int, bytes]) -> None:
    """Log an episode with its film: WebP pictures by frame, empty without a film."""
    entities.log_static((), entities.rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    cameras = _cameras(episode)
    for v, (view, camera) in enumerate(cameras.items()):
        entities.log_camera(view, camera)
        if film:
            _log_film(entities, episode, view, v, camera, film)
        _log_detections(entities, episode, view)
    for kind, colours, radius_m in (
        ("truth", TRUTH_RGB, 0.008),
        ("estimate", TARGET_RGB, 0.012),
    ):
        points_m = 1e-3 * episode.points_mm(kind)
        _log_points(entities, episode, kind, points_m, colours, radius_m)
        _log_trails(entities, episode, kind, points_m, colours)
    _log_covariances(entities, episode, 1e-3 * episode.points_mm("estimate"))
    for name in ("error_mm", "err_acc_px"):
        _log_curves(entities, episode, name)
    _log_events(entities, episode)
    _log_labels(entities, episode)


def _log_per_frame(
    entities: Entities,
    episode: EpisodeTables,
    parts: Sequence[str],
    columns: Any,
    counts: Sequence[int],
) -> None:
    """Log values in the order of frames; counts (F,): the number of values of each frame.

    A frame without a value has an empty row: the viewer goes on showing the last one otherwise.
    """
    times = _times(entities, episode, np.arange(len(episode.index)))
    # An episode without any value has no column to cut up.
    if sum(counts):
        entities.stream.send_columns(entities.path(*parts), times, columns.partition(counts))


def _log_at(
    entities: Entities,
    episode: EpisodeTables,
    parts: Sequence[str],
    positions: Sequence[int],
    columns: Any,
) -> None:
    """Log a value at each of these positions among the episode's frames."""
    if len(positions):
        times = _times(entities, episode, np.array(positions))
        entities.stream.send_columns(entities.path(*parts), times, columns)


def _times(entities: Entities, episode: EpisodeTables, positions: np.ndarray) -> list[Any]:
    return [
        entities.rr.TimeColumn("frame", sequence=episode.index[positions]),
        entities.rr.TimeColumn("time", duration=episode.column("time_s")[positions, 0]),
    ]


def _cameras(episode: EpisodeTables) -> dict[str, Camera]:
    return {
        str(row["view"]): Camera(
            K=np.array(row["K"]).reshape(3, 3),
            R_cw=np.array(row["R_cw"]).reshape(3, 3),
            t_cw=np.array(row["t_cw"]),
            width_px=int(row["width_px"]),
            height_px=int(row["height_px"]),
        )
        for row in episode.cameras.to_dict("records")
    }


def _log_film(
    entities: Entities,
    episode: EpisodeTables,
    view: str,
    v: int,
    camera: Camera,
    film: Mapping[int, bytes],
) -> None:
    parts = ("cameras", view, "picture")
    entities.log_static(parts, entities.rr.EncodedImage.from_fields(media_type="image/jpeg"))
    pictures = [_picture(film[frame], v, camera) for frame in episode.index if frame in film]
    counts = [int(frame in film) for frame in episode.index]
    _log_per_frame(
        entities, episode, parts, entities.rr.EncodedImage.columns(blob=pictures), counts
    )


def _picture(sheet: bytes, v: int, camera: Camera) -> bytes:
    """One view of a film's frame (`reports.pictures.stills`) at its camera's size, as JPEG."""
    views = picture_of(sheet)
    assert views is not None, "a run's films are checked when it is read"
    height = round(VIEW_WIDTH_PX * camera.height_px / camera.width_px)
    small = views[:height, v * VIEW_WIDTH_PX : (v + 1) * VIEW_WIDTH_PX]
    size = (camera.width_px, camera.height_px)  # shapes drawn over it are in the camera's pixels
    large = cv2.resize(small, size, interpolation=cv2.INTER_CUBIC)
    return jpeg_of(np.asarray(large, np.uint8), QUALITY)


def _log_detections(entities: Entities, episode: EpisodeTables, view: str) -> None:
    mine = episode.detections[episode.detections["view"] == view]
    shapes = mine[["x_px", "y_px", "a_px", "b_px", "angle_rad"]].to_numpy(dtype=np.float64)
    strips = [_outline(*shape) for shape in shapes.tolist()]
    counts = mine.groupby("frame").size().reindex(episode.index, fill_value=0).tolist()
    parts = ("cameras", view, "detections")
    lines = entities.rr.LineStrips2D
    entities.log_static(parts, lines.from_fields(colors=[DETECTION_RGB], radii=[1.0]))
    _log_per_frame(entities, episode, parts, lines.columns(strips=strips), counts)


def _outline(x: float, y: float, a: float, b: float, angle_rad: float) -> Floats:
    """A closed ellipse (49, 2) in the viewer's pixels."""
    points = ellipse_points(np.array([x, y]) + CORNER_PX, a, b, angle_rad)
    return np.vstack([points, points[:1]])


def _log_points(
    entities: Entities,
    episode: EpisodeTables,
    kind: str,
    points_m: Floats,
    colours: Sequence[tuple[int, int, int]],
    radius_m: float,
) -> None:
    cloud = entities.rr.Points3D
    for t, target in enumerate(TARGETS):
        there = np.isfinite(points_m[:, t]).all(axis=1)
        entities.log_static(
            (kind, target), cloud.from_fields(colors=[colours[t]], radii=[radius_m])
        )
        columns = cloud.columns(positions=points_m[there, t])
        _log_per_frame(entities, episode, (kind, target), columns, there.astype(int).tolist())


def _log_trails(
    entities: Entities,
    episode: EpisodeTables,
    kind: str,
    points_m: Floats,
    colours: Sequence[tuple[int, int, int]],
) -> None:
    lines = entities.rr.LineStrips3D
    times_s = episode.column("time_s")[:, 0].astype(np.float64)
    starts = np.searchsorted(times_s, times_s - TRAIL_S - 1e-9)
    for t, target in enumerate(TARGETS):
        trails = [
            _unbroken(points_m[start : frame + 1, t]) for frame, start in enumerate(starts.tolist())
        ]
        parts = ("trail", kind, target)
        entities.log_static(parts, lines.from_fields(colors=[colours[t]], radii=[0.002]))
        strips = [strip for trail in trails for strip in trail]
        _log_per_frame(
            entities, episode, parts, lines.columns(strips=strips), [len(trail) for trail in trails]
        )


def _unbroken(points_m: Floats) -> list[Floats]:
    """Stretches (n >= 2, 3) of a path (m, 3) without a gap (NaN)."""
    there = np.isfinite(points_m).all(axis=1)
    pieces = np.split(points_m, np.flatnonzero(~there))
    whole = [piece[np.isfinite(piece).all(axis=1)] for piece in pieces]
    return [piece for piece in whole if len(piece) > 1]


def _log_covariances(entities: Entities, episode: EpisodeTables, points_m: Floats) -> None:
    solid = entities.rr.Ellipsoids3D
    covariances_m2 = np.empty((*points_m.shape, 3))
    for i, a in enumerate("xyz"):
        for j, b in enumerate("xyz"):
            pair = "".join(sorted(a + b))
            covariances_m2[..., i, j] = episode.column(f"covariance_{pair}_m2")
    for t, target in enumerate(TARGETS):
        there = np.isfinite(points_m[:, t]).all(axis=1)
        there &= np.isfinite(covariances_m2[:, t]).all(axis=(1, 2))
        variances, axes = np.linalg.eigh(covariances_m2[there, t])
        axes[..., 0] *= np.linalg.det(axes)[:, None]  # a rotation, no mirror
        columns = solid.columns(
            centers=points_m[there, t],
            half_sizes=SIGMAS * np.sqrt(np.maximum(variances, 0.0)),
            quaternions=Rotation.from_matrix(axes).as_quat() if there.any() else np.zeros((0, 4)),
        )
        parts = ("covariance", target)
        # Colour is not the only sign. In the pictures, letters would cover the hands.
        style = {"colors": [TARGET_RGB[t]], "labels": [LETTERS[t]], "show_labels": True}
        entities.log_static(parts, solid.from_fields(**style))
        _log_per_frame(entities, episode, parts, columns, there.astype(int).tolist())


def _log_curves(entities: Entities, episode: EpisodeTables, name: str) -> None:
    values = episode.column(name).astype(np.float64)
    for t, target in enumerate(TARGETS):
        there = np.isfinite(values[:, t])
        entities.log_static(
            (name, target),
            entities.rr.SeriesLines(colors=[TARGET_RGB[t]], names=[LABELS[target]]),
        )
        columns = entities.rr.Scalars.columns(scalars=values[there, t])
        _log_per_frame(entities, episode, (name, target), columns, there.astype(int).tolist())


def _log_events(entities: Entities, episode: EpisodeTables) -> None:
    rows = episode.events.to_dict("records")
    # A recovery is shown where it ends, all other events where they start.
    frames = [row["last_frame" if row["kind"] == "recovered" else "first_frame"] for row in rows]
    order = sorted(range(len(rows)), key=lambda i: int(frames[i]))
    columns = entities.rr.TextLog.columns(
        text=[_event_line(rows[i]) for i in order],
        level=["INFO" if rows[i]["kind"] == "recovered" else "WARN" for i in order],
    )
    places = np.searchsorted(episode.index, [frames[i] for i in order])
    _log_at(entities, episode, ("events",), places.tolist(), columns)


def _event_line(event: Mapping[Any, Any]) -> str:
    link = "after" if event["kind"] == "recovered" else "for"
    blame = f"; at fault: {event['blame']}" if event["blame"] else ""
    return f"{event_text(event)} {link} {event['duration_s']:.1f} s{blame}"


def _log_labels(entities: Entities, episode: EpisodeTables) -> None:
    """Log the scenario's events of a frame, wherever they change."""
    labels = episode.column("labels")[:, 0].tolist()
    places = [i for i, label in enumerate(labels) if i == 0 or label != labels[i - 1]]
    texts = [labels[i].replace(";", ", ") or "-" for i in places]
    columns = entities.rr.TextLog.columns(text=texts, level=["INFO"] * len(texts))
    _log_at(entities, episode, ("labels",), places, columns)
