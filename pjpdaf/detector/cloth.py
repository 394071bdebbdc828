"""Clothes of a colour near skin: the pixels of the skin range that are shirt, not hand or face."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pjpdaf.arrays import Bools, Floats
from pjpdaf.detector.chroma import log_chroma
from pjpdaf.detector.face import USUAL_DEPTH_M, Face

SKIN_M2 = 0.11  # more in the skin range than head, hands and rolled sleeves: some is clothes
BIN, BINS, LOW = 0.02, 128, -1.0  # of the histogram of log chroma
NEAR = 0.04  # radius of the clothes' cluster in log chroma
LEAST_SHARE = 0.3  # of the pixels away from the face
CLEAR_M2, CLEAR = 0.08, 0.09  # enough where the clothes are so far from the face in log chroma
APART = 0.036  # between face and clothes, in log chroma: nearer than this nobody can tell them
REACH = np.ones((5, 5), np.uint8)  # fingers, thinner than a hand
BOUNDS = 0.4, 0.65  # of the way from the face to the clothes, where clothes begin


def cloth_mask(
    logs: Sequence[np.ndarray], skin: Bools, face: Face, focal_px: float, clear: bool = True
) -> np.ndarray | None:
    """Find clothes among skin-coloured pixels, uint8 (h, w), 0 or 1; None where there are none.

    logs: of the reduced picture (h, w), as of `SmallPicture`; skin: bool (h, w), its foreground in
    the skin range; focal_px: of the reduced picture. clear: clothes of a colour far from the
    face's are clothes where less is in the skin range too, as of a person far away. The clothes are
    the largest cluster of log chroma away from the face's; a pixel belongs to the nearer of the
    two, by their spread.
    """
    metre_px = focal_px / USUAL_DEPTH_M
    size_m2 = float(skin.sum()) / metre_px**2
    if size_m2 < (CLEAR_M2 if clear else SKIN_M2):
        return None
    blue, green, red = (log[skin] for log in logs)
    chroma = np.stack([red - green, green - blue], axis=-1)
    of_face = log_chroma(face.bgr)
    cloth = _largest(chroma, of_face)
    if cloth is None:
        return None
    way = cloth - of_face
    distance = float(np.linalg.norm(way))
    if size_m2 < SKIN_M2 and distance < CLEAR:
        return None
    along = (chroma - of_face) @ (way / distance) / distance  # 0 at the face, 1 at the clothes
    facelike, clothlike = np.abs(along) < 0.4, np.abs(along - 1.0) < 0.4
    spread = along[facelike].std() if facelike.sum() > 1 else 0.2
    other = along[clothlike].std() if clothlike.sum() > 1 else 0.2
    border = float(np.clip(spread / max(spread + other, 1e-6), *BOUNDS))
    mask = np.zeros(skin.shape, np.uint8)
    mask[skin] = along <= border
    # Edges of clothes mix with what is behind and may look like skin: what is thin and away from
    # hand and face is no skin.
    kept = cv2.dilate(cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)), REACH)
    kept &= mask
    clothes = (skin & (kept == 0)).astype(np.uint8)
    clothes = cv2.dilate(clothes, np.ones((3, 3), np.uint8))
    return np.asarray(clothes & (1 - kept), np.uint8)


def _largest(chroma: Floats, of_face: Floats) -> Floats | None:
    """Centre (2,) of the largest cluster that is APART from the face, None without a large one."""
    away: Bools = ((chroma - of_face) ** 2).sum(axis=1) > APART**2
    if away.sum() < LEAST_SHARE * len(chroma):
        return None
    rest = chroma[away]
    at = ((rest - LOW) / BIN).astype(np.intp).clip(0, BINS - 1)
    counts = np.bincount(at[:, 0] * BINS + at[:, 1], minlength=BINS * BINS)
    u, v = np.unravel_index(int(counts.argmax()), (BINS, BINS))
    centre = LOW + (np.array([u, v]) + 0.5) * BIN
    for _ in range(3):
        near = ((rest - centre) ** 2).sum(axis=1) < NEAR**2
        if near.sum() < LEAST_SHARE * len(rest):
            return None
        centre = rest[near].mean(axis=0)
    return centre if np.linalg.norm(centre - of_face) > APART else None
