"""Head: a track of its own, with the area and shape that it has when nothing touches it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import HeadPlace
from pjpdaf.tracker.hypotheses.centres import CROWN_M, head_offset
from pjpdaf.tracker.hypotheses.geometry import Views, stereo_information
from pjpdaf.tracker.hypotheses.hair_beside import hair_beside
from pjpdaf.tracker.hypotheses.motion import correct, spread
from pjpdaf.tracker.hypotheses.nearer_head import nearer_head
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.hypotheses.split import settle

MERGED_RATIO = 1.10  # of the remembered area: a larger blob is head and something else
LOOSE_RATIO = 1.45  # up to this it may be the head that turned, and is learnt slowly
PARTLY_RATIO = 0.55  # a smaller blob is not the whole head
MEMORY, SLOW_MEMORY = 0.15, 0.05  # shares of a sighting in the remembered area and shape
FARTHEST_M = 0.45  # from the prediction, the more the longer it is unseen
RESIDUAL_PX = 6.0  # rms, of two views that agree
MERGED_PX = 4.0, 1.5  # deviations of a merged head's centre: common to the views, between them
ALONG_RAY_M = 0.1
CROWNS_M = 0.10, 0.22  # of people


@dataclass(frozen=True, eq=False)
class HeadTrack:
    """The head's state.

    mean (3,) [m] of the visible skin's centre; covariance (3, 3); area_m2; shape_m2 (2, 2) second
    moments of the free head; crown_m height of the silhouette's top, the hair, above the centre
    of the skin; beside_m width of hair beside the face, None: not known; unseen_s time since it was
    seen.
    """

    mean: Floats
    covariance: Floats
    area_m2: float
    shape_m2: Floats
    crown_m: float = CROWN_M
    beside_m: float | None = None
    unseen_s: float = 0.0

    def centre(self, axes: Floats, p: HypothesisParameters) -> Floats:
        """Centre of the head (3,) [m]."""
        offset = head_offset(axes, self.shape_m2, self.crown_m, self.beside_m, p.offsets)
        return np.asarray(self.mean + offset)


def follow_head(
    track: HeadTrack,
    seen: tuple[Blobs, ...],
    views: Views,
    dt_s: float,
    p: HypothesisParameters,
    known_m: Floats | None = None,
    joined: tuple[bool, ...] = (False, False),
) -> tuple[HeadTrack, tuple[HeadPlace | None, ...]]:
    """The head one frame later, and its place in each view, None where it is not seen.

    known_m (3,): where it is looked for in place of the prediction. joined: of each view, whether a
    hand must be in the head's blob, which is then neither free nor learnt, whatever its area.
    """
    looked_for = track if known_m is None else replace(track, mean=known_m)
    places = head_places(looked_for, seen, views, joined)
    if p.candidates.nearer_head and not any(joined):
        most_px = RESIDUAL_PX * views.scale
        places = nearer_head(
            places, seen, views, track.area_m2, track.shape_m2, MERGED_RATIO, most_px
        )
    sighting = _sighting(track, places, views, p)
    m = p.motion
    if sighting is None:
        grown = track.covariance + spread(dt_s, m.head_weights, m.head_deviations_m)
        return replace(track, covariance=grown, unseen_s=track.unseen_s + dt_s), places
    point, C = sighting
    mean, P = correct(
        track.mean, track.covariance, point, C, dt_s, m.head_weights, m.head_deviations_m
    )
    after = replace(track, mean=mean, covariance=P, unseen_s=0.0)
    if any(place is None for place in places) or any(joined):
        return after, places
    free = all(place is not None and place.free for place in places)
    area, shape = head_size(mean, seen, places, views)
    if not free and area > LOOSE_RATIO * track.area_m2:
        return after, places
    memory = MEMORY if free else SLOW_MEMORY
    crown = crown_of(mean, seen, views)
    beside = hair_beside(mean, seen, views)
    learnt = replace(
        after,
        crown_m=track.crown_m + (0.0 if crown is None else memory * (crown - track.crown_m)),
        beside_m=_mean(track.beside_m, beside, memory),
        area_m2=(1 - memory) * track.area_m2 + memory * area,
        shape_m2=(1 - memory) * track.shape_m2 + memory * shape,
    )
    return learnt, places


def _mean(before: float | None, now: float | None, memory: float) -> float | None:
    """A running mean; None while nothing is known."""
    if before is None or now is None:
        return now if before is None else before
    return before + memory * (now - before)


def head_places(
    track: HeadTrack,
    seen: tuple[Blobs, ...],
    views: Views,
    joined: tuple[bool, ...] = (False, False),
) -> tuple[HeadPlace | None, ...]:
    """Places of the head, judged at the prediction. joined: as of `follow_head`."""
    pixels, depth = views.project(track.mean)
    places: list[HeadPlace | None] = []
    for view, blobs in enumerate(seen):
        metre_px = views.focal_px[view] / depth[view]
        shape, area = track.shape_m2 * metre_px**2, track.area_m2 * metre_px**2
        reach_px = float(FARTHEST_M * (1.0 + track.unseen_s) * metre_px)
        place = _place(blobs, pixels[view], shape, float(area), reach_px)
        if place is not None and place.free and joined[view]:
            centre, _ = settle(blobs.looks.pixels[place.blob], pixels[view], shape)
            place = replace(place, free=False, centre_px=centre, as_free=True)
        places.append(place)
    return tuple(places)


def _place(
    blobs: Blobs, expected: Floats, shape: Floats, area: float, reach_px: float
) -> HeadPlace | None:
    """The likeliest blob: one of the head's size, or one in which an ellipse comes to rest."""
    best: HeadPlace | None = None
    least = math.inf
    for i in range(len(blobs)):
        ratio = float(blobs.areas_px[i]) / area
        if PARTLY_RATIO <= ratio <= MERGED_RATIO:
            distance = float(np.linalg.norm(blobs.centres_px[i] - expected))
            if not distance < reach_px:
                continue
            cost = (distance / (0.35 * reach_px)) ** 2 + abs(math.log(ratio))
            cost += _elongation_cost(blobs.ellipses[i], shape)
            if cost < least:
                best, least = HeadPlace(i, True, blobs.centres_px[i], shape), cost
        elif ratio > 0.25:
            centre, inside = settle(blobs.looks.pixels[i], expected, shape)
            filled = inside * blobs.looks.pixel_area_px / area
            moved = float(np.linalg.norm(centre - expected))
            cost = (moved / (0.2 * reach_px)) ** 2 + 3.0 * max(0.0, 0.9 - filled) + 0.5
            if filled > 0.4 and moved < 0.5 * reach_px and cost < least:
                best, least = HeadPlace(i, False, centre, shape), cost
    return best


def _elongation_cost(ellipse: Floats, shape: Floats) -> float:
    """How much a blob's elongation differs from the head's."""
    values = np.linalg.eigvalsh(shape)
    expected = (values[1] / max(values[0], 1e-9)) ** 0.5
    return float(abs(np.log(max(ellipse[2] / max(ellipse[3], 1e-9), 1e-9) / expected)))


def _sighting(
    track: HeadTrack, places: tuple[HeadPlace | None, ...], views: Views, p: HypothesisParameters
) -> tuple[Floats, Floats] | None:
    """Point (3,) and covariance (3, 3) of the head; None where it is unseen or the views differ."""
    at = [(view, place) for view, place in enumerate(places) if place is not None]
    if len(at) == 2:
        (_, one), (_, two) = at
        points, residual = views.triangulate(one.centre_px[None], two.centre_px[None])
        reach = FARTHEST_M * (1.0 + track.unseen_s)
        if (
            residual[0] > RESIDUAL_PX * views.scale
            or np.linalg.norm(points[0] - track.mean) > reach
        ):
            return None
        common, between = p.noise.whole_px if one.free and two.free else MERGED_PX
        information = stereo_information(
            views.jacobians(points),
            np.array([common * views.scale]),
            # Views that differ show different pieces of the head: their depth says little.
            np.array([float(np.hypot(between * views.scale, residual[0]))]),
        )[0]
        return points[0], np.asarray(np.linalg.inv(information))
    if len(at) == 1:
        ((view, place),) = at
        ray = views.rays(view, place.centre_px[None])[0]
        point = views.centres_m[view] + views.project(track.mean)[1][view] * ray
        H = views.jacobians(point[None])[0, view]
        unit = ray / np.linalg.norm(ray)
        along = np.outer(unit, unit) / ALONG_RAY_M**2
        information = H.T @ H / (MERGED_PX[0] * views.scale) ** 2 + along
        return point, np.asarray(np.linalg.inv(information))
    return None


def head_size(
    mean: Floats, seen: tuple[Blobs, ...], places: tuple[HeadPlace | None, ...], views: Views
) -> tuple[float, Floats]:
    """Mean area [m^2] and second moments (2, 2) [m^2] of the blobs that show the head."""
    _, depth = views.project(mean)
    areas, shapes = [], []
    for view, place in enumerate(places):
        if place is None:
            continue
        size = (depth[view] / views.focal_px[view]) ** 2
        areas.append(float(seen[view].areas_px[place.blob]) * size)
        _, _, a, b, angle = seen[view].ellipses[place.blob]
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s], [s, c]])
        shapes.append(turn @ np.diag([a * a / 4, b * b / 4]) @ turn.T * size)
    return float(np.mean(areas)), np.asarray(np.mean(shapes, axis=0))


def crown_of(mean: Floats, seen: tuple[Blobs, ...], views: Views) -> float | None:
    """Height [m] of the silhouette's top above the head's centre; None where no view shows it."""
    pixels, depth = views.project(mean)
    heights_m = []
    for view, blobs in enumerate(seen):
        shape = blobs.looks.silhouette
        if shape is None:
            continue
        classes, step = shape.classes, shape.step_px
        row, column = int((pixels[view, 1] + 0.5) / step), int((pixels[view, 0] + 0.5) / step)
        if not (3 <= column < classes.shape[1] - 3 and 0 <= row < classes.shape[0]):
            continue
        above = classes[row::-1, column - 3 : column + 4] > 0
        if above.all(axis=0).any() or not above[0].any():
            continue  # it reaches the edge of the picture
        height_px = (float(np.median(above.argmin(axis=0))) - 0.5) * step
        heights_m.append(height_px * depth[view] / views.focal_px[view])
    crown = float(np.mean(heights_m)) if heights_m else 0.0
    return crown if CROWNS_M[0] < crown < CROWNS_M[1] else None
