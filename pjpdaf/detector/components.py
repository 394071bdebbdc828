"""Connected components of the skin mask, fragments joined (thesis 3.1.2)."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass

import cv2
import numpy as np

from pjpdaf.arrays import Ints
from pjpdaf.camera import Camera, to_camera
from pjpdaf.checks import NotNegative, NotNegativeInt, check_bounds
from pjpdaf.interfaces import Estimates

FRAGMENT_MIN_PX = 4  # smaller specks are noise that the opening left
FRAGMENTS_MAX = 40  # a picture with more is noise; joining them would cost time and mean nothing


@dataclass(frozen=True)
class ComponentParameters:
    """Cleaning of the mask, and the components that are kept."""

    # Smallest component kept [px], A_min of Table 4.1 (500), here at the reference focal length.
    min_area_px: NotNegative = 150.0
    # min_area_px holds for this focal length [px] and this depth [m]; it is scaled by
    # (f / reference_focal_px)^2 (and by (reference_depth_m / Z)^2 where a depth Z is known).
    # 0 = unscaled, as in the thesis.
    reference_focal_px: NotNegative = 540.0
    reference_depth_m: NotNegative = 1.3
    # Diameter of the opening and closing elements [px]; 0 = none. "Combination of operations".
    open_px: NotNegativeInt = 3
    close_px: NotNegativeInt = 5
    # A component under min_area_px joins its nearest neighbour if that is nearer than its own
    # diameter (a sleeve, a cup or a shadow cut it off). Not in the thesis.
    merge_fragments: bool = True

    def __post_init__(self) -> None:
        check_bounds("DetectorParameters", self)


@dataclass(frozen=True, eq=False)
class Segments:
    """Accepted skin pixels of one picture: points (n, 2) whole x, y; component (n,) in 0..count-1;
    size (height, width) of the picture [px]. above_px, upto_px: any smallest area above the one and
    up to the other gives the same components [px].
    """

    points: Ints
    component: Ints
    count: int
    size: tuple[int, int]
    above_px: float = -math.inf
    upto_px: float = math.inf


def clean(mask: np.ndarray, open_px: int, close_px: int) -> np.ndarray:
    """Open, then close a uint8 mask (h, w) by discs of these diameters [px]; <= 1: neither."""
    x, y, width, height = cv2.boundingRect(mask)
    if width == 0 or max(open_px, close_px) <= 1:
        return mask
    # Only where the mask is; a rim as wide as the elements reach, so that nothing changes there.
    rim = max(open_px, 0) + max(close_px, 0) + 1
    rows, columns = (
        slice(max(y - rim, 0), y + height + rim),
        slice(max(x - rim, 0), x + width + rim),
    )
    window = mask[rows, columns]
    for diameter, operation in ((open_px, cv2.MORPH_OPEN), (close_px, cv2.MORPH_CLOSE)):
        if diameter > 1:
            disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (int(diameter), int(diameter)))
            window = cv2.morphologyEx(window, operation, disc)
    cleaned = np.zeros_like(mask)
    cleaned[rows, columns] = window
    return cleaned


def segments(mask: np.ndarray, min_area_px: float, merge_fragments: bool) -> Segments:
    """Return the 8-connected components of a uint8 mask (h, w) with at least min_area_px pixels.

    merge_fragments: a component under min_area_px joins its nearest neighbour, and only that, if it
    is not further away than its own diameter; so two large components are never joined. The area
    counts after that.
    """
    size = (mask.shape[0], mask.shape[1])
    x0, y0, width, height = cv2.boundingRect(mask)
    if width == 0:
        return Segments(np.zeros((0, 2), np.intp), np.zeros(0, np.intp), 0, size)
    box = mask[y0 : y0 + height, x0 : x0 + width]
    # At most every second row and column begins a component; few enough for 16 bits are faster.
    narrow = (width + 1) // 2 * ((height + 1) // 2) < 2**16 - 1
    count, labels = cv2.connectedComponents(box, ltype=cv2.CV_16U if narrow else cv2.CV_32S)
    at = np.flatnonzero(labels > 0)
    label = labels.reshape(-1)[at].astype(np.intp)
    rows, columns = np.divmod(at, width)
    areas = np.bincount(label, minlength=count)
    group = np.arange(count)
    if merge_fragments:
        group = _join_fragments(labels, label, (columns, rows), areas, min_area_px)
    total = np.bincount(group, weights=areas, minlength=count)
    kept = np.flatnonzero(total >= max(min_area_px, 1.0))
    number = np.full(count, -1, np.intp)
    number[kept] = np.arange(len(kept))
    of_label = number[group]
    of_label[0] = -1
    # The smallest area is compared with these, and only with these.
    compared = sorted([-math.inf, *areas[1:].tolist(), *total[1:].tolist(), math.inf])
    least = bisect_left(compared, min_area_px)
    above_px, upto_px = float(compared[least - 1]), float(compared[least])
    if len(kept) == 0:
        nothing = np.zeros((0, 2), np.intp), np.zeros(0, np.intp)
        return Segments(*nothing, 0, size, above_px, upto_px)
    component = of_label[label]
    points = np.empty((len(at), 2), np.intp)
    np.add(columns, x0, out=points[:, 0])
    np.add(rows, y0, out=points[:, 1])
    if -1 in of_label[1:].tolist():
        inside = component >= 0
        points, component = points[inside], component[inside]
    return Segments(points, component, len(kept), size, above_px, upto_px)


def _join_fragments(
    labels: np.ndarray, label: Ints, at: tuple[Ints, Ints], areas: Ints, min_area_px: float
) -> Ints:
    """Component of each label (count,), fragments joined to their nearest neighbour.

    labels (h, w); of its pixels that are not 0: label (n,), and columns and rows, at, (n,) each.
    """
    count = len(areas)
    parent = np.arange(count)
    small = [i for i in range(1, count) if FRAGMENT_MIN_PX <= areas[i] < min_area_px]
    small = sorted(small, key=lambda i: (-int(areas[i]), i))[:FRAGMENTS_MAX]
    for i in small:
        reach = 2.0 * math.sqrt(float(areas[i]) / math.pi)
        pad = math.ceil(reach)
        mine = label == i
        x, y = (axis[mine] for axis in at)
        window = labels[
            max(int(y.min()) - pad, 0) : int(y.max()) + 1 + pad,
            max(int(x.min()) - pad, 0) : int(x.max()) + 1 + pad,
        ]
        other = (window != i) & (window != 0)
        if not other.any():
            continue
        # Distance of each pixel of the window to the fragment (whose pixels are the zeros).
        distance = cv2.distanceTransform(
            (window != i).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
        )
        # Squares are whole numbers; the last bit of a distance depends on where it lies in memory,
        # and of pixels at the same distance the first shall count.
        squared = np.rint(distance * distance)
        squared[~other] = np.inf
        nearest = int(np.argmin(squared))
        j = int(window.ravel()[nearest])
        root = int(_root(parent, j))
        # A speck must not carry a chain; root == i: the two are each other's nearest.
        near = float(squared.ravel()[nearest]) <= reach * reach
        if near and areas[j] >= FRAGMENT_MIN_PX and root != i:
            parent[i] = root
    return np.array([_root(parent, i) for i in range(count)], np.intp)


def _root(parent: Ints, i: int) -> int:
    while parent[i] != i:
        i = int(parent[i])
    return i


def min_area_px(p: ComponentParameters, camera: Camera, predicted: Estimates | None) -> float:
    """Return the smallest component of this view [px]: areas go with (f / Z)^2.

    Z is the median depth of the targets that `predicted` says are tracked; without any,
    reference_depth_m. The scale for depth is kept within 1/4 .. 4, as a prediction may be wrong.
    """
    area = p.min_area_px
    if p.reference_focal_px > 0:
        area *= camera.K[0, 0] * camera.K[1, 1] / p.reference_focal_px**2
    if p.reference_depth_m > 0 and predicted is not None:
        tracked = np.array([s == "tracked" for s in predicted.status], dtype=bool)
        depths = to_camera(camera, predicted.positions_m[tracked])[:, 2]
        depths = depths[np.isfinite(depths) & (depths > 0)]
        if len(depths):
            area *= min(max((p.reference_depth_m / float(np.median(depths))) ** 2, 0.25), 4.0)
    return float(area)
