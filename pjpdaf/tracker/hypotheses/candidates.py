"""Candidates: places in one view at which a hand may be: blobs and parts of blobs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pjpdaf.arrays import Floats, Ints
from pjpdaf.tracker.hypotheses.bare_arm import end_at, ends_and_middles
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.parameters import CandidateParameters
from pjpdaf.tracker.hypotheses.split import LEAST, halves, outside, pieces

WHOLE, HALF, OTHER_HALF, BESIDE, END, OTHER_END = range(6)  # parts of a blob
LONGEST_FINGERS = 0.4  # of the square root of the area
APART, KEPT = 1.1, (0.4, 1.1)  # shares of two halves' distance: hands side by side; at all
PIECES = 3  # beside the head, at most
END_SHARE = 0.8  # of a hand's length: how far the end of a bare arm reaches


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidates of one view.

    centres_px (c, 2); areas_px (c,); blob (c,) and part (c,), WHOLE .. OTHER_END; palm_px (c, 2)
    from the centre to the middle of the palm, 0 for parts; pixels (k, 2) of pieces beside the
    head, whose outline is their own, else None; mate (c,): the only candidate of the other view
    that can be the same, -1 for any; between_px (c,): deviation of such a centre between the views.
    uncut: the first of two halves that are still to be cut, whose centres and areas are NaN, and
    the share of their distance that is the hands'.
    """

    centres_px: Floats
    areas_px: Floats
    blob: Ints
    part: Ints
    palm_px: Floats
    pixels: tuple[Floats | None, ...]
    mate: Ints
    between_px: Floats
    uncut: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class HeadPlace:
    """The head in one view: its blob; free: nothing else is in that blob; centre_px (2,);
    shape_px2 (2, 2) second moments of the free head there; as_free: the blob is as large as the
    free head.
    """

    blob: int
    free: bool
    centre_px: Floats
    shape_px2: Floats
    as_free: bool = False


class Candidate(NamedTuple):
    """One candidate: centre (2,) [px], area [px], part, pixels (k, 2) of a piece; together: of the
    first of two halves that are still to be cut, the share of their distance that is the hands'.
    """

    centre_px: Floats
    area_px: float
    part: int
    pixels: Floats | None = None
    together: float | None = None


def candidates(
    view: Blobs,
    head: HeadPlace | None,
    metre_px: float,
    hand_area_m2: float,
    bare: bool,
    p: CandidateParameters,
    cut: bool = True,
) -> Candidates:
    """All candidates of a view; the blob of the head offers only what is beside the head.

    metre_px: pixels of a metre where hands are; hand_area_m2: of a whole hand. bare: the person's
    forearms are bare, so that the hand is an end of a long blob. head: None before the start, when
    each blob counts as it is too. cut: halve blobs now; `halve_together` does what is left.
    """
    hand_px = hand_area_m2 * metre_px**2
    chosen: list[Candidate] = []
    blob: list[int] = []
    for i in range(len(view)):
        if head is not None and i == head.blob:
            here = [] if head.free else list(_beside(view, head, metre_px, hand_px, bare, p))
        else:
            here = list(_of_blob(view, i, metre_px, hand_px, bare, head is None, cut, p))
        chosen += here
        blob += [i] * len(here)
    part = np.array([c.part for c in chosen], np.intp)
    blobs = np.array(blob, np.intp)
    palm = np.zeros((len(chosen), 2))
    whole = part == WHOLE
    # Sideways they say nothing: hands point inwards more or less alike (`centres.py`).
    down = np.clip(view.looks.fingers[blobs[whole], 1], -LONGEST_FINGERS, LONGEST_FINGERS)
    palm[whole, 1] = -p.palm * down * np.sqrt(view.areas_px[blobs[whole]])
    return Candidates(
        np.array([c.centre_px for c in chosen]).reshape(-1, 2),
        np.array([c.area_px for c in chosen], np.float64),
        blobs,
        part,
        palm,
        tuple(c.pixels for c in chosen),
        np.full(len(chosen), -1),
        np.zeros(len(chosen)),
        {k: c.together for k, c in enumerate(chosen) if c.together is not None},
    )


def _of_blob(
    view: Blobs,
    i: int,
    metre_px: float,
    hand_px: float,
    bare: bool,
    always: bool,
    cut: bool,
    p: CandidateParameters,
) -> Iterator[Candidate]:
    pixels, area = view.looks.pixels[i], float(view.areas_px[i])
    arm = bare and p.ends and view.length_m(i, metre_px) > p.hand_length_m and len(pixels) >= 8
    hands, size = None, area
    if arm and view.thickness_m(i, metre_px) > p.arm_thickness_m:
        size = min(area, p.split_area_m2 * metre_px**2)
        step = view.looks.pixel_area_px**0.5
        tips, hands = ends_and_middles(pixels, step, END_SHARE * p.hand_length_m * metre_px)
        for k in range(2):
            yield Candidate(tips[k].mean(axis=0), size, END + k, tips[k])
    if not arm or always:  # the head itself may be long
        yield Candidate(view.centres_px[i], area, WHOLE)
    if p.halves and area > p.split_area_m2 * metre_px**2:
        if hands is not None and p.middles:
            for k in range(2):
                yield Candidate(hands[k].mean(axis=0), size, HALF + k, hands[k])
        elif cut or len(pixels) < LEAST:
            yield from _halves(pixels, area, hand_px, p)
        else:
            unknown = np.full(2, np.nan)
            yield Candidate(unknown, np.nan, HALF, None, drawn_together(area, hand_px, p))
            yield Candidate(unknown, np.nan, OTHER_HALF)


def _halves(
    pixels: Floats, area_px: float, hand_px: float, p: CandidateParameters
) -> Iterator[Candidate]:
    """Two hands of which one hides a part of the other are nearer than the blob's halves.

    How much is hidden shows in the area. Only halves that are cut in both views at once have depths
    of their own (`stereo_split.py`): where one hand hides most of the other, both halves' sides are
    the nearer hand's.
    """
    two = halves(pixels, drawn_together(area_px, hand_px, p))
    if two is not None:
        for k in range(2):
            yield Candidate(two[0][k], area_px * float(two[1][k]), HALF + k)


def drawn_together(area_px: float, hand_px: float, p: CandidateParameters) -> float:
    """Share of two halves' distance that is the hands': the less, the more of them is hidden."""
    share = APART - p.draw_together * hidden_share(area_px, hand_px)
    return min(max(share, KEPT[0]), KEPT[1])


def hidden_share(area_px: float, hand_px: float) -> float:
    """Share of two hands that is hidden in a blob of an area; hand_px: of one hand."""
    return 1.0 - area_px / (2.0 * hand_px)


def _beside(
    view: Blobs,
    head: HeadPlace,
    metre_px: float,
    hand_px: float,
    bare: bool,
    p: CandidateParameters,
) -> Iterator[Candidate]:
    """Pieces of the head's blob outside the head, and halves of a piece as large as two hands.

    A piece longer than a hand is a bare arm: the hand is its end at the head.
    """
    if not p.beside_head:
        return
    each = view.looks.pixel_area_px
    left = outside(view.looks.pixels[head.blob], head.centre_px, head.shape_px2, p.head_scale)
    least = max(int(p.beside_area_m2 * metre_px**2 / each), 6)
    for piece in pieces(left, each**0.5, least)[:PIECES]:
        area = len(piece) * each
        if bare and p.ends and _length_px(piece) > p.hand_length_m * metre_px:
            centre = end_at(piece, each**0.5, head.centre_px, p.hand_length_m * metre_px)
            yield Candidate(centre, min(area, p.split_area_m2 * metre_px**2), BESIDE)
            continue
        yield Candidate(piece.mean(axis=0), area, BESIDE, piece)
        if p.halves and area > 1.2 * p.split_area_m2 * metre_px**2:
            yield from _halves(piece, area, hand_px, p)


def _length_px(pixels: Floats) -> float:
    """Length of the ellipse with the second moments of pixels (n, 2), as of `Blobs.length_m`."""
    return float(4.0 * np.sqrt(np.linalg.eigvalsh(np.cov(pixels.T))[1]))
