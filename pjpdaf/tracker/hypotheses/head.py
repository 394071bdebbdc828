"""The head: one track of its own, with the area and shape that it has when nothing touches it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.detector.blob_detector import BlobDetections
from pjpdaf.detector.split import settle
from pjpdaf.tracker.hypotheses.candidates import Head
from pjpdaf.tracker.hypotheses.geometry import Views, stereo_information
from pjpdaf.tracker.hypotheses.motion import correct, spread
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters

MERGED_RATIO = 1.10  # of the remembered area: a larger blob is head and something else
CROWN_M = 0.157  # of an average person
CROWN_SHARE = 0.74  # by which the skin's centre is lower where the hair begins lower, fitted
LOOSE_RATIO = 1.45  # up to this it may be the head that turned, and is learnt slowly
SLOW_MEMORY = 0.05
PARTLY_RATIO = 0.55  # a smaller blob is not the whole head
MEMORY = 0.15  # share of a free sighting in the remembered area and shape
FARTHEST_M = 0.45  # from the prediction


@dataclass(frozen=True, eq=False)
class HeadTrack:
    """mean (3,) [m] of the visible skin's centre; covariance (3, 3); area_m2; shape_m2 (2, 2) second
    moments of the free head, times (depth / focal)^2; crown_m height of the silhouette's top, the
    hair, above the centre of the skin; unseen_s.
    """

    mean: Floats
    covariance: Floats
    area_m2: float
    shape_m2: Floats
    crown_m: float = CROWN_M
    unseen_s: float = 0.0

    def centre(self, axes: Floats, p: HypothesisParameters) -> Floats:
        """Centre of the head (3,) [m]: how far it is above the centre of the skin goes with how
        much the hair hides.
        """
        right, down, away = p.head_offset_m
        down -= CROWN_SHARE * (self.crown_m - CROWN_M)
        return np.asarray(self.mean + np.array([right, down, away]) @ axes)


def head_places(
    track: HeadTrack, seen: tuple[BlobDetections, ...], views: Views
) -> tuple[Head | None, ...]:
    """Per view the blob that shows the head, judged at the prediction; None: no picture or blob."""
    pixels, depth = views.project(track.mean)
    found: list[Head | None] = []
    for view, blobs in enumerate(seen):
        scale = (views.focal_px[view] / depth[view]) ** 2
        shape, area = track.shape_m2 * scale, track.area_m2 * scale
        found.append(_place(blobs, pixels[view], shape, area, FARTHEST_M * scale**0.5))
    return tuple(found)


def _place(
    blobs: BlobDetections, expected: Floats, shape: Floats, area: float, reach_px: float
) -> Head | None:
    best: Head | None = None
    least = 1e9
    for i in range(len(blobs)):
        ratio = float(blobs.areas_px[i]) / area
        offset = blobs.centres_px[i] - expected
        distance = float(np.linalg.norm(offset))
        if PARTLY_RATIO <= ratio <= MERGED_RATIO:
            cost = (distance / (0.35 * reach_px)) ** 2 + abs(np.log(ratio))
            if distance < reach_px and cost < least:
                flat = _flatness(blobs.ellipses[i], shape)
                if flat + cost < least:
                    best, least = Head(i, True, blobs.centres_px[i], shape), cost + flat
        elif blobs.pixels and ratio > 0.25:
            centre, inside = settle(blobs.pixels[i], expected, shape)
            filled = inside * blobs.pixel_area_px / area
            moved = float(np.linalg.norm(centre - expected))
            cost = (moved / (0.2 * reach_px)) ** 2 + 3.0 * max(0.0, 0.9 - filled) + 0.5
            if filled > 0.4 and moved < 0.5 * reach_px and cost < least:
                best, least = Head(i, False, centre, shape), cost
    return best


def _flatness(ellipse: Floats, shape: Floats) -> float:
    """How much a blob's elongation differs from the head's."""
    values = np.linalg.eigvalsh(shape)
    expected = (values[1] / max(values[0], 1e-9)) ** 0.5
    return float(abs(np.log(max(ellipse[2] / max(ellipse[3], 1e-9), 1e-9) / expected)))


def follow_head(
    track: HeadTrack,
    seen: tuple[BlobDetections, ...],
    views: Views,
    dt_s: float,
    p: HypothesisParameters,
) -> tuple[HeadTrack, tuple[Head | None, ...]]:
    """The head one frame later and where each view shows it."""
    places = head_places(track, seen, views)
    at = [v for v, place in enumerate(places) if place is not None]
    noise = p.noise
    if len(at) >= 2 and places[0] is not None and places[1] is not None:
        one, two = places[0], places[1]
        points, residual = views.triangulate(one.centre_px[None], two.centre_px[None])
        free = one.free and two.free
        common, between = (noise.whole_px if free else (4.0, 1.5))
        if residual[0] < 6.0 * views.scale and np.linalg.norm(points[0] - track.mean) < FARTHEST_M:
            information = stereo_information(
                views.jacobians(points),
                np.array([common * views.scale]),
                np.array([between * views.scale]),
            )[0]
            m = p.motion
            mean, P, _ = correct(
                track.mean,
                track.covariance,
                points[0],
                np.linalg.inv(information),
                dt_s,
                m.head_weights,
                m.head_deviations_m,
            )
            after = replace(track, mean=mean, covariance=P, unseen_s=0.0)
            grown = max(
                float(seen[v].areas_px[place.blob])
                * (float(views.project(points[0])[1][v]) / views.focal_px[v]) ** 2
                for v, place in enumerate((one, two))
            )
            alone = free or grown < LOOSE_RATIO * track.area_m2
            memory = MEMORY if free else SLOW_MEMORY
            return (_remember(after, seen, places, views, memory) if alone else after), places
    elif len(at) == 1:
        view = at[0]
        place = places[view]
        assert place is not None
        depth = views.project(track.mean)[1][view]
        ray = views.rays(view, place.centre_px[None])[0]
        point = views.centres_m[view] + depth * ray
        H = views.jacobians(point[None])[0, view]
        unit = ray / np.linalg.norm(ray)
        information = H.T @ H / (4.0 * views.scale) ** 2 + np.outer(unit, unit) / 0.1**2
        m = p.motion
        mean, P, _ = correct(
            track.mean,
            track.covariance,
            point,
            np.linalg.inv(information),
            dt_s,
            m.head_weights,
            m.head_deviations_m,
        )
        return replace(track, mean=mean, covariance=P, unseen_s=0.0), places
    held = replace(
        track,
        covariance=track.covariance + spread(dt_s, p.motion.head_weights, p.motion.head_deviations_m),
        unseen_s=track.unseen_s + dt_s,
    )
    return held, places


def _remember(
    track: HeadTrack,
    seen: tuple[BlobDetections, ...],
    places: tuple[Head | None, ...],
    views: Views,
    memory: float,
) -> HeadTrack:
    area, shape = head_size(track.mean, seen, places, views)
    crown = crown_of(track.mean, seen, views)
    return replace(
        track,
        crown_m=track.crown_m + (0.0 if crown is None else memory * (crown - track.crown_m)),
        area_m2=(1 - memory) * track.area_m2 + memory * area,
        shape_m2=(1 - memory) * track.shape_m2 + memory * shape,
    )


def head_size(
    mean: Floats,
    seen: tuple[BlobDetections, ...],
    places: tuple[Head | None, ...],
    views: Views,
) -> tuple[float, Floats]:
    """Mean area [m^2] and second moments (2, 2) [m^2] of the blobs that show the head."""
    _, depth = views.project(mean)
    areas, shapes = [], []
    for view, place in enumerate(places):
        if place is None:
            continue
        size = (depth[view] / views.focal_px[view]) ** 2
        areas.append(float(seen[view].areas_px[place.blob]) * size)
        x, y, a, b, angle = seen[view].ellipses[place.blob]
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s], [s, c]])
        shapes.append(turn @ np.diag([a * a / 4, b * b / 4]) @ turn.T * size)
    return float(np.mean(areas)), np.asarray(np.mean(shapes, axis=0))


def crown_of(mean: Floats, seen: tuple[BlobDetections, ...], views: Views) -> float | None:
    """Height [m] of the silhouette's top above the head's centre, mean over the views."""
    pixels, depth = views.project(mean)
    found = []
    for view, blobs in enumerate(seen):
        if blobs.silhouette is None:
            continue
        classes, step = blobs.silhouette.classes, blobs.silhouette.step_px
        row, column = int((pixels[view, 1] + 0.5) / step), int((pixels[view, 0] + 0.5) / step)
        if not (3 <= column < classes.shape[1] - 3 and 0 <= row < classes.shape[0]):
            continue
        above = classes[row::-1, column - 3 : column + 4] > 0
        if above.all(axis=0).any() or not above[0].any():
            continue  # reaches the edge of the picture
        height_px = (float(np.median(above.argmin(axis=0))) - 0.5) * step
        found.append(height_px * depth[view] / views.focal_px[view])
    crown = float(np.mean(found)) if found else 0.0
    return crown if 0.10 < crown < 0.22 else None
