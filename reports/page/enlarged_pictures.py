"""Overlay pictures of a run inside the page, as many as its bytes allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from pjpdaf.errors import BenchError
from reports.page.packing import data_address
from reports.pictures.encode import picture_of, webp_of
from reports.run.load import SavedRun

MAX_PICTURES = 8
PICTURE_BYTES = 750_000  # of all enlarged pictures on a page
PICTURE_WIDTH_PX = 960
PICTURE_QUALITY = 50  # of WebP


@dataclass(frozen=True)
class EnlargedPicture:
    """A picture inside the page that a click enlarges: its caption and data address."""

    caption: str
    address: str


def enlarged_pictures(
    runs: Sequence[SavedRun],
) -> dict[tuple[int, str, int], tuple[EnlargedPicture, ...]]:
    """Pictures by run, scenario and seed: of each episode as many as the page has room for.

    Raises BenchError where a picture cannot be read.
    """
    stored: dict[tuple[int, str, int], list[Mapping[str, Any]]] = {}
    for r, run in enumerate(runs):
        for picture in run.meta["pictures"]:
            stored.setdefault((r, picture["scenario"], picture["seed"]), []).append(picture)
    chosen: dict[tuple[int, str, int], tuple[EnlargedPicture, ...]] = {}
    left = PICTURE_BYTES
    for place, (key, pictures) in enumerate(stored.items()):
        # An even share of the room that is left: small pictures leave more to the next.
        share = left // (len(stored) - place)
        middle = _spread(pictures, 1)[0]
        sample = _smaller(runs[key[0]], middle)
        most = min(MAX_PICTURES, share // max(len(sample), 1))
        kept = []
        for picture in _spread(pictures, most):
            webp = sample if picture is middle else _smaller(runs[key[0]], picture)
            if len(webp) > left:
                break
            left -= len(webp)
            caption = f"frame {picture['frame']}"
            kept.append(EnlargedPicture(caption, data_address("image/webp", webp)))
        if kept:
            chosen[key] = tuple(kept)
    return chosen


def _smaller(run: SavedRun, picture: Mapping[str, Any]) -> bytes:
    """Encode a picture of a run as a WebP of the page's width."""
    path = run.folder / picture["file"]
    try:
        jpeg = path.read_bytes()
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    sheet = picture_of(jpeg)
    if sheet is None:
        raise BenchError(f"{path}: is no picture.")
    height, width = sheet.shape[:2]
    if width > PICTURE_WIDTH_PX:
        size = (PICTURE_WIDTH_PX, round(height * PICTURE_WIDTH_PX / width))
        sheet = np.asarray(cv2.resize(sheet, size, interpolation=cv2.INTER_AREA), np.uint8)
    return webp_of(sheet, PICTURE_QUALITY)


def _spread(items: Sequence[Mapping[str, Any]], most: int) -> list[Mapping[str, Any]]:
    """At most `most` items, evenly spread from first to last; a single item is the middle."""
    if len(items) <= most:
        return list(items)
    if most <= 1:
        return [items[len(items) // 2]] if most else []
    return [items[round(i * (len(items) - 1) / (most - 1))] for i in range(most)]
