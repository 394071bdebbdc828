"""Opening of a mask by a large disc, on whole rows of bits at once."""

from __future__ import annotations

import numpy as np


def opened_by(disc: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Open a mask uint8 (h, w), 0 or 1, by a disc: uint8 (h, w), the bits of `cv2.MORPH_OPEN`.

    disc: uint8 (2 r + 1, 2 r + 1), 0 or 1, symmetric, rows no longer than those nearer the middle.
    The mask must be 0 in its first and last row and column. It is one long number, which shifts
    move as a whole: several times as fast as pixel by pixel, and the more so the larger the disc.
    """
    width = mask.shape[1]
    middle = len(disc) // 2
    # From the outermost row of the disc: how far down it is, and its reach to either side.
    sides = (disc[: middle + 1].sum(axis=1) // 2).tolist()
    rows = list(zip(range(middle, -1, -1), sides, strict=True))
    packed = np.packbits(mask)
    run, reach = int.from_bytes(packed.tobytes(), "big"), 0
    kept = -1  # all bits
    for down, side in rows:
        while reach < side:
            run &= (run << 1) & (run >> 1)
            reach += 1
        kept &= (run << down * width) & (run >> down * width)
    run, reach, result = kept, 0, 0
    for down, side in rows:
        while reach < side:
            run |= (run << 1) | (run >> 1)
            reach += 1
        result |= (run << down * width) | (run >> down * width)
    bits = np.frombuffer(result.to_bytes(len(packed), "big"), np.uint8)
    return np.unpackbits(bits, count=mask.size).reshape(mask.shape)
