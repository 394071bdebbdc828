"""Film strips of failures: some frames about the moment, truth and estimates drawn in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import pandas as pd

from pjpdaf.arrays import Floats, Image
from pjpdaf.camera import Camera, project
from pjpdaf.targets import LEFT_HAND, RIGHT_HAND
from reports.page.episode_tables import EpisodeTables
from reports.pictures.contact_sheet import GAP_PX
from reports.pictures.encode import picture_of
from reports.pictures.overlay import SHIFT, STRIP, WHITE, draw_text, fixed, text_width
from reports.pictures.wrong_marks import RED, TILE_PX, WRONG_M, crop_about, marked_tile
from reports.words import EXCHANGED, event_text

OFFSETS_S = (-1.4, -0.7, -0.35, 0.0, 0.7, 1.7)  # of the frames, from the start of the event
# The schematic of a frame without a picture: BGR, as the page's player draws it.
GROUND, SKIN = (51, 42, 35), (97, 112, 130)
RADII_M = (0.105, 0.045, 0.045)
_KINDS = ("swap", "capture", "lost")  # in the order in which a badge names them
_OF_MEASURE = {"swap": ("swap",), "head_right": ("capture", "swap"), "head_left": ("capture",)}


@dataclass(frozen=True, eq=False)
class Tile:
    """A frame of a strip: its picture (h, w, 3) BGR, and its badge, "" where all is well."""

    frame: int
    time_s: float
    picture: Image
    badge: str


def strip(episode: EpisodeTables, film: Mapping[int, bytes], measure: str) -> tuple[Tile, ...]:
    """The strip of an episode, in the left view.

    film: WebP pictures of both views by frame; frames without one are drawn as a schematic.
    measure: of `reports.score.robustness`, whose first event is shown.
    """
    places = _places(episode, measure)
    camera = camera_of(episode.cameras.to_dict("records")[0])
    truth = episode.points_mm("truth") / 1e3
    estimates = episode.points_mm("estimate") / 1e3
    pixels = [(project(camera, truth[i]), project(camera, estimates[i])) for i in places]
    crop = crop_about(
        np.concatenate([p for pair in pixels for p in pair]), (camera.width_px, camera.height_px)
    )
    errors = episode.column("error_mm").astype(np.float64)
    status = episode.column("status")
    tiles = []
    for i, (truth_px, estimates_px) in zip(places, pixels, strict=True):
        frame = int(episode.index[i])
        badge = badge_of(episode.events, frame)
        wrong = errors[i] > 1e3 * WRONG_M
        if badge == EXCHANGED:
            wrong[[RIGHT_HAND, LEFT_HAND]] = True
        picture = marked_tile(
            _left_view(film.get(frame), camera, truth[i]),
            crop,
            camera.width_px,
            truth_px,
            estimates_px,
            wrong,
            status[i] == "tracked",
        )
        tiles.append(Tile(frame, float(episode.column("time_s")[i, 0]), picture, badge))
    return tuple(tiles)


def sheet(tiles: Sequence[Tile]) -> Image:
    """A strip as one picture (h, w, 3) BGR, with frame numbers and badges."""
    width, height = TILE_PX
    canvas = np.full((height + 26, len(tiles) * (width + GAP_PX) - GAP_PX, 3), STRIP, np.uint8)
    for n, tile in enumerate(tiles):
        x = n * (width + GAP_PX)
        canvas[:height, x : x + width] = tile.picture
        draw_text(canvas, f"{tile.time_s:.1f} s", (x + 6, height + 18), WHITE, 0.45)
        if tile.badge:
            right = x + width - text_width(tile.badge, 0.45) - 6
            draw_text(canvas, tile.badge, (right, height + 18), _light(RED), 0.45)
    return canvas


def badge_of(events: pd.DataFrame, frame: int) -> str:
    """The worst event of a frame in words: an exchange, a capture, a loss; else ""."""
    here = events[(events["first_frame"] <= frame) & (events["last_frame"] >= frame)]
    for kind in _KINDS:
        rows = here[here["kind"] == kind].to_dict("records")
        if rows:
            return EXCHANGED if kind == "swap" else event_text(rows[0])
    return ""


def start_of(episode: EpisodeTables, measure: str) -> int:
    """The frame in which the first event of a measure starts; else that of the largest error."""
    events = episode.events
    if measure.startswith("lost_"):
        target = {"head": "head", "right": "right_hand", "left": "left_hand"}[measure[5:]]
        mine = events[(events["kind"] == "lost") & (events["target"] == target)]
    else:
        mine = events[events["kind"].isin(_OF_MEASURE.get(measure, ("swap",)))]
    if not len(mine):
        mine = events[events["kind"].isin(_KINDS)]
    if len(mine):
        return int(mine["first_frame"].min())
    errors = np.nan_to_num(episode.column("error_mm").astype(np.float64), nan=0.0)
    return int(episode.index[int(errors.sum(axis=1).argmax())])


def camera_of(row: Mapping[str, object]) -> Camera:
    """A camera of a row of the table of cameras, without its lens distortion."""
    return Camera(
        np.array(row["K"], dtype=np.float64).reshape(3, 3),
        np.array(row["R_cw"], dtype=np.float64).reshape(3, 3),
        np.array(row["t_cw"], dtype=np.float64),
        int(str(row["width_px"])),
        int(str(row["height_px"])),
    )


def _places(episode: EpisodeTables, measure: str) -> list[int]:
    """Positions of the strip's frames: about the start of the event, each once."""
    times: Floats = episode.column("time_s")[:, 0].astype(np.float64)
    start = int(np.searchsorted(episode.index, start_of(episode, measure)))
    wanted = times[min(start, len(times) - 1)] + np.array(OFFSETS_S)
    places = {int(np.abs(times - t).argmin()) for t in wanted}
    more = (i for i in range(start, len(times)) if i not in places)
    while len(places) < min(len(OFFSETS_S), len(times)):
        places.add(next(more, None) or min(set(range(len(times))) - places))
    return sorted(places)


def _left_view(webp: bytes | None, camera: Camera, truth_m: Floats) -> Image:
    """The left view as filmed; without a picture a schematic of head and hands."""
    picture = picture_of(webp) if webp is not None else None
    return _schematic(camera, truth_m) if picture is None else picture[:, : picture.shape[1] // 2]


def _schematic(camera: Camera, truth_m: Floats) -> Image:
    """Head and hands as discs where they really are (T, 3) [m], the far ones first."""
    canvas = np.full((camera.height_px, camera.width_px, 3), GROUND, dtype=np.uint8)
    depths_m = truth_m @ camera.R_cw[2] + camera.t_cw[2]
    centres_px = project(camera, truth_m)
    for t in np.argsort(-depths_m).tolist():
        if np.isfinite(centres_px[t]).all():
            radius, _ = fixed(np.full(2, RADII_M[t] * camera.K[0, 0] / depths_m[t]))
            cv2.circle(canvas, fixed(centres_px[t]), radius, SKIN, -1, cv2.LINE_AA, SHIFT)
    return canvas


def _light(colour: tuple[int, int, int]) -> tuple[int, int, int]:
    b, g, r = ((c + 2 * 150) // 3 if c < 150 else c for c in colour)
    return b, g, r
