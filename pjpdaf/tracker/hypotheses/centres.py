"""Centres of head and hands, from the centres of their visible skin."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats, Ints
from pjpdaf.tracker.hypotheses.blobs import Blobs
from pjpdaf.tracker.hypotheses.candidates import END, WHOLE
from pjpdaf.tracker.hypotheses.parameters import OffsetParameters

# Of an average person: height of the hair's top above the centre of the skin, twice
# the deviations of the skin's pixels across and down, width of what is beside the face.
CROWN_M, BREADTH_M, HEIGHT_M, BESIDE_M = 0.153, 0.0735, 0.095, 0.030
BREADTHS_M, HEIGHTS_M = (0.060, 0.090), (0.060, 0.100)  # within which they tell


def outward(parts: Ints, seen: tuple[Blobs, ...], axes: Floats, p: OffsetParameters) -> Floats:
    """Vectors (2, n, 3) [m] from n sightings to the palm, if they show the right or left hand.

    Elbows hang outside the body, so that fingers point inwards, and with them the centre of a
    hand's skin; of halves and pieces it is what happens to be visible. parts (n, views), as of
    `Pairs`; axes (3, 3): rows right, down, forward of the first camera, which the person faces.
    Where no view has a silhouette, points come from elsewhere and are palms already.
    """
    hand = ((parts <= WHOLE) | (parts >= END)).all(axis=1)
    hand &= any(view.looks.silhouette is not None for view in seen)
    right = np.where(hand, -p.outward_m, 0.0)
    return np.asarray(np.stack([right, -right])[..., None] * axes[0])


def head_offset(
    axes: Floats, shape_m2: Floats, crown_m: float, beside_m: float | None, p: OffsetParameters
) -> Floats:
    """Vector (3,) [m] from the centre of the head's visible skin to the head's centre.

    The centre is below the hair's top by a length that goes with the head's breadth. The more of
    ears and neck is hidden, by hair beside the face or a beard below it, the less deep is the skin.
    shape_m2 (2, 2): second moments of the skin; crown_m, beside_m: height of the hair's top above
    its centre, width of what is beside it, None where no silhouette showed it: the same for all.
    """
    right, down, away = p.head_offset_m
    if beside_m is None:
        return np.asarray(np.array([right, down, away]) @ axes)
    breadth_m, height_m = 2.0 * np.sqrt(np.maximum(np.diag(shape_m2), 0.0))
    down -= p.crown_share * (crown_m - CROWN_M)
    down += p.breadth_share * (float(np.clip(breadth_m, *BREADTHS_M)) - BREADTH_M)
    away += p.beside_share * (beside_m - BESIDE_M)
    away -= p.height_share * (float(np.clip(height_m, *HEIGHTS_M)) - HEIGHT_M)
    return np.asarray(np.array([right, down, away]) @ axes)
