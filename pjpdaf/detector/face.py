"""Colour of a person's face, from the top of the silhouette; light and white balance from it.

Where the fixed skin range does not hold the face, the picture is multiplied, channel by channel, so
that the face has the reference colour: a change of light or of white balance is such a product
(von Kries), and so is most of the difference between persons.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from pjpdaf.arrays import Bools, Floats, mean_point, median, quantile
from pjpdaf.detector.chroma import log_chroma
from pjpdaf.detector.shoulders import rows_of_head

REFERENCE_BGR = (79.0, 101.0, 142.0)  # of skin in the middle of the fixed range
HEAD_M, HALF_HEAD_M = 0.27, 0.10  # height below the silhouette's top, half width
USUAL_DEPTH_M = 1.3
JOIN_M = 0.06  # pieces nearer than twice this are one person
ELSEWHERE_M = 0.2  # from the expected head: the silhouette's top is not it
TOP_M = 0.05  # least width of the silhouette at its top
DARK = 0.35  # share of the box's bright value below which a pixel is hair or shade
BIN, BINS, LOW = 0.04, 64, -1.0  # of the histogram of log chroma
REDDER, REDDER_SD = (0.36, 0.26), (0.15, 0.20)  # log chroma of skin above the background's
ODDEST = 3.0  # deviations from that, of a face
NEAR = 0.10  # radius of the face's cluster in log chroma
LEAST_SHARE = 0.06  # of the box
GAINS = 0.2, 8.0  # of a channel, at the least and at most
# Face colours (hue [deg], saturation, least value) that the fixed range holds with its spread.
FITS_HUE_DEG, FITS_SATURATION, FITS_VALUE = (8.0, 34.0), (0.28, 0.62), 0.30


@dataclass(frozen=True, eq=False)
class Face:
    """Colour of the face: bgr (3,) 0-255; pixels that show it, of the reduced picture."""

    bgr: Floats
    pixels: int

    @property
    def fits(self) -> bool:
        """Whether the fixed range holds skin of this colour."""
        b, g, r = self.bgr / 255.0
        hue, saturation, value = colorsys.rgb_to_hsv(r, g, b)
        hue_deg = (360.0 * hue + 180.0) % 360.0 - 180.0
        low, high = FITS_SATURATION
        return bool(
            FITS_HUE_DEG[0] <= hue_deg <= FITS_HUE_DEG[1]
            and low <= saturation <= high
            and value >= FITS_VALUE
        )


class ExpectedHead(NamedTuple):
    """Where a head is expected in a reduced picture: centre (2,) [px]; pixels of a metre there."""

    centre_px: Floats
    metre_px: float

    def near(self, middle_px: tuple[float, float]) -> bool:
        """Whether a pixel is within ELSEWHERE_M."""
        return bool(np.hypot(*(middle_px - self.centre_px)) < ELSEWHERE_M * self.metre_px)

    def box(self) -> tuple[int, int, int, int]:
        """Rows and columns of a head's size there, the first and the one after the last."""
        (x, y), half = self.centre_px, HALF_HEAD_M * self.metre_px
        up, down = y - 0.5 * HEAD_M * self.metre_px, y + 0.5 * HEAD_M * self.metre_px
        top, bottom, left, right = (max(int(side), 0) for side in (up, down, x - half, x + half))
        return top, bottom, left, right


class HeadPlace(NamedTuple):
    """Where a face was looked for in a reduced picture.

    top_px: middle of the head's size below the silhouette's top, None without any; box: rows and
    columns of the expected head (`ExpectedHead.box`) if it was there instead, None for the top.
    """

    top_px: tuple[float, float] | None = None
    box: tuple[int, int, int, int] | None = None

    def serves(self, expected: ExpectedHead | None) -> bool:
        """Whether a face that is expected here is looked for in the same place."""
        if expected is None:
            return self.box is None
        at_top = self.top_px is not None and expected.near(self.top_px)
        return at_top if self.box is None else not at_top and expected.box() == self.box


def head_place(
    foreground: np.ndarray,
    focal_px: float,
    expected: ExpectedHead | None = None,
    to_shoulders: bool = True,
) -> tuple[HeadPlace, Bools | None]:
    """Find where the head shows: the place, and its foreground, bool (h, w), None without any.

    foreground: uint8 (h, w), non-zero where the person is; focal_px: of the reduced picture.
    expected: the silhouette's top counts only if it is there: another person may stand taller.
    to_shoulders: the head ends where the silhouette widens.
    """
    top = _top_of(foreground, focal_px / USUAL_DEPTH_M, to_shoulders)
    top_px = None
    if top is not None:
        rows, columns = np.divmod(np.flatnonzero(top), top.shape[1])
        top_px = float(columns.mean()), float(rows.mean())
    if expected is None or (top_px is not None and expected.near(top_px)):
        return HeadPlace(top_px), top
    up, down, left, right = box = expected.box()
    inside: Bools = np.zeros(foreground.shape, np.bool_)
    inside[up:down, left:right] = foreground[up:down, left:right] > 0
    return HeadPlace(top_px, box), inside if inside.any() else None


def face_in(inside: Bools, small: np.ndarray, background_chroma: Floats) -> Face | None:
    """Find the face's colour in a reduced picture uint8 (h, w, 3), None where there is none.

    inside: bool (h, w), where the head shows; background_chroma (2,): of the scene.
    """
    at = np.flatnonzero(inside)
    colours = small.reshape(-1, 3).take(at, axis=0).astype(np.float32)
    blue, green, red = colours.T  # numpy reduces an axis of 3 slowly
    value = np.maximum(np.maximum(blue, green), red)
    colours = colours[value >= DARK * quantile(value, 0.95)]
    chroma = log_chroma(colours)
    bins = ((chroma - LOW) / BIN).astype(np.intp).clip(0, BINS - 1)
    numbers = np.bincount(bins[:, 0] * BINS + bins[:, 1], minlength=BINS * BINS)
    counts = cv2.GaussianBlur(numbers.reshape(BINS, BINS).astype(np.float32), (0, 0), 1.0)
    centres = LOW + (np.arange(BINS) + 0.5) * BIN
    for axis in range(2):
        off = (centres - background_chroma[axis] - REDDER[axis]) / REDDER_SD[axis]
        prior = np.exp(-0.5 * off * off).astype(np.float32)
        counts *= prior[:, None] if axis == 0 else prior[None, :]
    u, v = np.unravel_index(int(counts.argmax()), counts.shape)
    centre = np.array([centres[u], centres[v]])
    one, two = np.ascontiguousarray(chroma.T)  # numpy reduces an axis of 2 slowly
    for _ in range(3):
        near = (one - centre[0]) ** 2 + (two - centre[1]) ** 2 < NEAR**2
        if np.count_nonzero(near) < LEAST_SHARE * len(at):
            return None
        centre = mean_point(chroma[near])
    off = (centre - background_chroma - REDDER) / REDDER_SD
    if (off * off).sum() > ODDEST**2:
        return None
    bgr = [float(median(channel)) for channel in np.ascontiguousarray(colours[near].T)]
    return Face(np.array(bgr), int(np.count_nonzero(near)))


def _top_of(foreground: np.ndarray, metre_px: float, to_shoulders: bool) -> Bools | None:
    """Foreground below the top of the largest component, bool (h, w)."""
    size = 2 * round(JOIN_M * metre_px) + 1
    near = cv2.dilate(foreground, np.ones((size, size), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        near, connectivity=8, ltype=cv2.CV_16U
    )
    if count < 2:
        return None
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    person = (labels == largest) & (foreground > 0)
    rows = np.flatnonzero(person.sum(axis=1) >= TOP_M * metre_px)
    if not len(rows):
        return None
    top, height = int(rows[0]), max(int(HEAD_M * metre_px), 4)
    columns = np.flatnonzero(person[top : top + height // 3 + 1].any(axis=0))
    between = columns[(len(columns) - 1) // 2], columns[len(columns) // 2]  # they are in order
    middle, half = float(between[0] + between[1]) / 2, HALF_HEAD_M * metre_px
    if to_shoulders:
        height = rows_of_head(person, top, height, middle, metre_px)
    box: Bools = np.zeros(person.shape, np.bool_)
    box[top : top + height, max(int(middle - half), 0) : int(middle + half) + 1] = True
    box &= person
    return box if box.any() else None


def mean_face(faces: list[Face]) -> Face | None:
    """Return the mean colour of the faces that the views show, None without any."""
    if not faces:
        return None
    weights = np.array([face.pixels for face in faces], np.float64)
    bgr = np.average([face.bgr for face in faces], axis=0, weights=weights)
    return Face(np.asarray(bgr), int(weights.sum()))


def to_reference(picture: np.ndarray, face: Face) -> np.ndarray:
    """Multiply the channels of a picture uint8 (h, w, 3) so that the face has REFERENCE_BGR."""
    gains = np.clip(np.array(REFERENCE_BGR) / np.maximum(face.bgr, 1.0), *GAINS)
    levels = np.arange(256)[:, None] * gains[None, :]
    table = np.clip(np.rint(levels), 0, 255).astype(np.uint8)[None]
    balanced: np.ndarray = cv2.LUT(picture, table)
    return balanced
