"""A saved run as a recording for the Rerun viewer: cameras, films, paths, errors and events.

Written in memory first: Rerun's own files tell of a full disk only as a RuntimeError.
"""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.targets import TARGETS
from reports.page.player import Take, event_words, takes
from reports.pictures.overlay import LETTERS, ellipse_points
from reports.pictures.stills import VIEW_WIDTH_PX
from reports.run.films import read_film
from reports.run.load import SavedRun
from reports.score.records import VIEWS
from reports.summary.tables import LABELS
from sim.files import disk_faults, written_whole_file

SUFFIX = ".rrd"
APPLICATION = "pjpdaf-bench"
TRAIL_S = 2.0
SIGMAS = 2.0  # half axes of the ellipsoids
QUALITY = 60  # of the pictures as JPEG: the viewer reads no WebP
# As the report page's dark side (page.css), like the viewer: told apart by the colour-blind, too.
ESTIMATE_RGB = ((255, 143, 94), (63, 214, 160), (116, 189, 255))
TRUTH_RGB = ((156, 95, 66), (49, 128, 106), (72, 124, 166))
SEEN_RGB = (255, 225, 60)
# Rerun counts pixels from the corner of the top-left pixel, we from its centre.
CORNER_PX = 0.5


def write_rerun(run: SavedRun, file: Path) -> Path:
    """Write all episodes with a result into one new `file` (.rrd) and return it.

    Entities are scenario/seed/..., on the timelines `frame` and `time`; all lengths in metres, the
    world of the simulator (x towards the cameras, y to the person's left, z up), pixels of the
    undistorted pictures. Equal runs give equal content but for Rerun's chunk and row ids and the
    order of its chunks.

    Raises BenchError where the file exists or ends otherwise, or the run has nothing to show;
    InfrastructureError where Rerun is not installed or switched off, or the disk is full.
    """
    if file.suffix.lower() != SUFFIX:
        raise BenchError(f"{file}: must end in {SUFFIX}.")
    if run.slim:
        raise BenchError(f"{run.folder}: is a slim run, without frames; there is nothing to show.")
    if run.frames.empty:
        raise BenchError(f"{run.folder}: no episode has a result; there is nothing to show.")
    rr = _rerun(file)
    with written_whole_file(file, "the recording") as part, _strict(rr):
        content = _recording(rr, run)
        with disk_faults(file, "the recording"):
            part.write_bytes(content)
    return file


def recording_id(run: SavedRun) -> str:
    """Equal for equal runs: the viewer merges recordings of the same id."""
    files = json.dumps(run.meta["files"], sort_keys=True)
    return hashlib.sha256(files.encode()).hexdigest()[:32]


def _rerun(file: Path) -> Any:
    try:
        return importlib.import_module("rerun")
    except ImportError:
        raise InfrastructureError(
            f"{file}: recordings need the extra: pip install 'pjpdaf-bench[viz]'."
        ) from None


@contextmanager
def _strict(rr: Any) -> Iterator[None]:
    """Faults in what is logged are raised; else Rerun warns and leaves the data out."""
    before = rr.strict_mode()
    rr.set_strict_mode(True)
    try:
        yield
    finally:
        rr.set_strict_mode(before)


def _recording(rr: Any, run: SavedRun) -> bytes:
    """The whole recording as the bytes of a file."""
    # Its own properties are the wall-clock time and the program's name.
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id(run), send_properties=False)
    if not rr.is_enabled(stream):
        raise InfrastructureError("Rerun is switched off by the variable RERUN: unset it.")
    buffer = stream.binary_stream()
    stream.send_recording_name(run.name)
    films = {(film["scenario"], int(film["seed"])): film["file"] for film in run.meta["films"]}
    views: dict[str, list[Any]] = {}
    for take in takes(run):
        log = _Log(rr, stream, take)
        film = films.get((take.scenario, take.seed))
        _log_episode(log, read_film(run, film) if film else {})
        views.setdefault(take.scenario, []).append(_layout(log))
    tabs = importlib.import_module("rerun.blueprint").Tabs
    stream.send_blueprint(tabs(*[tabs(*seeds, name=name) for name, seeds in views.items()]))
    content: bytes = buffer.read()  # once: a second part would follow the file's end mark
    stream.disconnect()
    return content


@dataclass(frozen=True, eq=False)
class _Log:
    """Where an episode's data go."""

    rr: Any
    stream: Any
    take: Take

    def path(self, *parts: str) -> str:
        """Entity path below the episode."""
        return str(self.rr.new_entity_path([self.take.scenario, str(self.take.seed), *parts]))

    def always(self, parts: Sequence[str], *what: Any) -> None:
        """Of no time."""
        self.stream.log(self.path(*parts), *what, static=True)

    def per_frame(self, parts: Sequence[str], columns: Any, counts: Sequence[int]) -> None:
        """Values in the order of frames; counts (F,): how many of them each frame has.

        A frame without any has an empty row: the viewer goes on showing the last one otherwise.
        """
        times = self._times(np.arange(len(self.take.index)))
        # Of an episode without a value there is no column to be cut up.
        if sum(counts):
            self.stream.send_columns(self.path(*parts), times, columns.partition(counts))

    def at(self, parts: Sequence[str], places: Sequence[int], columns: Any) -> None:
        """A value at each of these places in the take's frames."""
        if len(places):
            self.stream.send_columns(self.path(*parts), self._times(np.array(places)), columns)

    def _times(self, places: np.ndarray) -> list[Any]:
        return [
            self.rr.TimeColumn("frame", sequence=self.take.index[places]),
            self.rr.TimeColumn("time", duration=self.take.column("time_s")[places, 0]),
        ]


def _log_episode(log: _Log, film: Mapping[int, bytes]) -> None:
    log.always((), log.rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    cameras = _cameras(log.take)
    for v, (view, camera) in enumerate(cameras.items()):
        _log_camera(log, view, camera)
        if film:
            _log_film(log, view, v, camera, film)
        _log_detections(log, view)
    for kind, colours, radius_m in (
        ("truth", TRUTH_RGB, 0.008),
        ("estimate", ESTIMATE_RGB, 0.012),
    ):
        points_m = 1e-3 * log.take.points_mm(kind)
        _log_points(log, kind, points_m, colours, radius_m)
        _log_trails(log, kind, points_m, colours)
    _log_covariances(log, 1e-3 * log.take.points_mm("estimate"))
    for name in ("error_mm", "err_acc_px"):
        _log_curves(log, name)
    _log_events(log)
    _log_labels(log)


def _cameras(take: Take) -> dict[str, Camera]:
    return {
        str(row["view"]): Camera(
            K=np.array(row["K"]).reshape(3, 3),
            R_cw=np.array(row["R_cw"]).reshape(3, 3),
            t_cw=np.array(row["t_cw"]),
            width_px=int(row["width_px"]),
            height_px=int(row["height_px"]),
        )
        for row in take.cameras.to_dict("records")
    }


def _log_camera(log: _Log, view: str, camera: Camera) -> None:
    K = np.array(camera.K)
    K[:2, 2] += CORNER_PX
    log.always(
        ("cameras", view),
        log.rr.Transform3D(translation=camera.centre_w, mat3x3=camera.R_cw.T),
        log.rr.Pinhole(
            image_from_camera=K,
            resolution=[camera.width_px, camera.height_px],
            camera_xyz=log.rr.ViewCoordinates.RDF,
            image_plane_distance=0.3,
        ),
    )


def _log_film(log: _Log, view: str, v: int, camera: Camera, film: Mapping[int, bytes]) -> None:
    parts = ("cameras", view, "picture")
    log.always(parts, log.rr.EncodedImage.from_fields(media_type="image/jpeg"))
    pictures = [_picture(film[frame], v, camera) for frame in log.take.index if frame in film]
    counts = [int(frame in film) for frame in log.take.index]
    log.per_frame(parts, log.rr.EncodedImage.columns(blob=pictures), counts)


def _picture(sheet: bytes, v: int, camera: Camera) -> bytes:
    """One view of a film's frame (`reports.pictures.stills`) at its camera's size, as JPEG."""
    views = cv2.imdecode(np.frombuffer(sheet, np.uint8), cv2.IMREAD_COLOR)
    assert views is not None, "a run's films are checked when it is read"
    height = round(VIEW_WIDTH_PX * camera.height_px / camera.width_px)
    small = views[:height, v * VIEW_WIDTH_PX : (v + 1) * VIEW_WIDTH_PX]
    size = (camera.width_px, camera.height_px)  # what lies on it is in the camera's pixels
    large = cv2.resize(small, size, interpolation=cv2.INTER_CUBIC)
    done, jpeg = cv2.imencode(".jpg", large, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(jpeg)


def _log_detections(log: _Log, view: str) -> None:
    mine = log.take.seen[log.take.seen["view"] == view]
    shapes = mine[["x_px", "y_px", "a_px", "b_px", "angle_rad"]].to_numpy(dtype=np.float64)
    strips = [_outline(*shape) for shape in shapes.tolist()]
    counts = mine.groupby("frame").size().reindex(log.take.index, fill_value=0).tolist()
    parts = ("cameras", view, "detections")
    lines = log.rr.LineStrips2D
    log.always(parts, lines.from_fields(colors=[SEEN_RGB], radii=[1.0]))
    log.per_frame(parts, lines.columns(strips=strips), counts)


def _outline(x: float, y: float, a: float, b: float, angle_rad: float) -> Floats:
    """A closed ellipse (49, 2) in the viewer's pixels."""
    points = ellipse_points(np.array([x, y]) + CORNER_PX, a, b, angle_rad)
    return np.vstack([points, points[:1]])


def _log_points(
    log: _Log,
    kind: str,
    points_m: Floats,
    colours: Sequence[tuple[int, int, int]],
    radius_m: float,
) -> None:
    cloud = log.rr.Points3D
    for t, target in enumerate(TARGETS):
        there = np.isfinite(points_m[:, t]).all(axis=1)
        log.always((kind, target), cloud.from_fields(colors=[colours[t]], radii=[radius_m]))
        columns = cloud.columns(positions=points_m[there, t])
        log.per_frame((kind, target), columns, there.astype(int).tolist())


def _log_trails(
    log: _Log, kind: str, points_m: Floats, colours: Sequence[tuple[int, int, int]]
) -> None:
    lines = log.rr.LineStrips3D
    times_s = log.take.column("time_s")[:, 0].astype(np.float64)
    starts = np.searchsorted(times_s, times_s - TRAIL_S - 1e-9)
    for t, target in enumerate(TARGETS):
        trails = [
            _unbroken(points_m[start : frame + 1, t]) for frame, start in enumerate(starts.tolist())
        ]
        parts = ("trail", kind, target)
        log.always(parts, lines.from_fields(colors=[colours[t]], radii=[0.002]))
        strips = [strip for trail in trails for strip in trail]
        log.per_frame(parts, lines.columns(strips=strips), [len(trail) for trail in trails])


def _unbroken(points_m: Floats) -> list[Floats]:
    """Stretches (n >= 2, 3) of a path (m, 3) without a gap (NaN)."""
    there = np.isfinite(points_m).all(axis=1)
    pieces = np.split(points_m, np.flatnonzero(~there))
    whole = [piece[np.isfinite(piece).all(axis=1)] for piece in pieces]
    return [piece for piece in whole if len(piece) > 1]


def _log_covariances(log: _Log, points_m: Floats) -> None:
    solid = log.rr.Ellipsoids3D
    covariances_m2 = np.empty((*points_m.shape, 3))
    for i, a in enumerate("xyz"):
        for j, b in enumerate("xyz"):
            pair = "".join(sorted(a + b))
            covariances_m2[..., i, j] = log.take.column(f"covariance_{pair}_m2")
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
        looks = {"colors": [ESTIMATE_RGB[t]], "labels": [LETTERS[t]], "show_labels": True}
        log.always(parts, solid.from_fields(**looks))
        log.per_frame(parts, columns, there.astype(int).tolist())


def _log_curves(log: _Log, name: str) -> None:
    values = log.take.column(name).astype(np.float64)
    for t, target in enumerate(TARGETS):
        there = np.isfinite(values[:, t])
        log.always(
            (name, target),
            log.rr.SeriesLines(colors=[ESTIMATE_RGB[t]], names=[LABELS[target]]),
        )
        columns = log.rr.Scalars.columns(scalars=values[there, t])
        log.per_frame((name, target), columns, there.astype(int).tolist())


def _log_events(log: _Log) -> None:
    rows = log.take.events.to_dict("records")
    # A target has recovered where the event ends; all others are told where they start.
    frames = [row["last_frame" if row["kind"] == "recovered" else "first_frame"] for row in rows]
    order = sorted(range(len(rows)), key=lambda i: int(frames[i]))
    columns = log.rr.TextLog.columns(
        text=[_words(rows[i]) for i in order],
        level=["INFO" if rows[i]["kind"] == "recovered" else "WARN" for i in order],
    )
    places = np.searchsorted(log.take.index, [frames[i] for i in order])
    log.at(("events",), places.tolist(), columns)


def _words(event: Mapping[Any, Any]) -> str:
    link = "after" if event["kind"] == "recovered" else "for"
    blame = f"; at fault: {event['blame']}" if event["blame"] else ""
    return f"{event_words(event)} {link} {event['duration_s']:.1f} s{blame}"


def _log_labels(log: _Log) -> None:
    """What happens in the scenario, wherever that changes."""
    labels = log.take.column("labels")[:, 0].tolist()
    places = [i for i, label in enumerate(labels) if i == 0 or label != labels[i - 1]]
    texts = [labels[i].replace(";", ", ") or "-" for i in places]
    columns = log.rr.TextLog.columns(text=texts, level=["INFO"] * len(texts))
    log.at(("labels",), places, columns)


def _layout(log: _Log) -> Any:
    """Views of one episode."""
    rrb = importlib.import_module("rerun.blueprint")
    moving = [f"{log.path(name)}/**" for name in ("truth", "estimate", "trail")]
    pictures = [
        rrb.Spatial2DView(
            origin=log.path("cameras", view), contents=["$origin/**", *moving], name=view
        )
        for view in VIEWS
    ]
    return rrb.Horizontal(
        rrb.Vertical(rrb.Spatial3DView(origin=log.path(), name="3-D"), rrb.Horizontal(*pictures)),
        rrb.Vertical(
            rrb.TimeSeriesView(origin=log.path("error_mm"), name="error [mm]"),
            rrb.TimeSeriesView(origin=log.path("err_acc_px"), name="accuracy error [px]"),
            rrb.TextLogView(
                origin=log.path(),
                contents=[log.path("events"), log.path("labels")],
                name="events",
            ),
        ),
        column_shares=[3, 2],
        name=f"seed {log.take.seed}",
    )
