"""The card's picture: a few frames with their labels."""

from __future__ import annotations

import cv2
import numpy as np

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.dataset import label_colours
from reports.pictures.encode import jpeg_of
from reports.pictures.resize import resized
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

SAMPLE_ROWS, TILE_PX, GAP_PX, TITLE_PX, QUALITY = 3, 248, 6, 26, 88


def sample_jpeg(dataset: Dataset) -> bytes:
    """Lay out a few frames, a row each: both views and the labels of the left view.

    They are of sequences spread evenly over the data set; of each the frame with most hidden.
    """
    if not dataset.sequences:
        raise BenchError(f"{dataset.folder}: has no finished sequence; there is nothing to show.")
    chosen = np.linspace(0, len(dataset.sequences) - 1, SAMPLE_ROWS).round().astype(int)
    sequences = [dataset.sequences[i] for i in sorted(set(chosen.tolist()))]
    rows = [_sample_row(sequence) for sequence in sequences]
    # Rigs may differ in their pictures' shape.
    height = max(tile.shape[0] for row in rows for tile in row.values())
    names = list(rows[0])
    width = GAP_PX + len(names) * (TILE_PX + GAP_PX)
    sheet = np.full(
        (TITLE_PX + len(rows) * (height + GAP_PX), width, 3), label_colours.EMPTY, np.uint8
    )
    for column, name in enumerate(names):
        x = GAP_PX + column * (TILE_PX + GAP_PX)
        title = name.replace("_", " ")
        cv2.putText(
            sheet, title, (x, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (235,) * 3, 1, cv2.LINE_AA
        )
        for r, row in enumerate(rows):
            y = TITLE_PX + r * (height + GAP_PX)
            tile = row[name]
            sheet[y : y + tile.shape[0], x : x + TILE_PX] = tile
    return jpeg_of(sheet, QUALITY, optimised=True)


def _sample_row(sequence: StoredSequence) -> dict[str, Image]:
    index = _most_hidden_frame(sequence)
    frame = sequence.frame(index)
    camera = sequence.rig.left
    grey = np.full((camera.height_px, camera.width_px, 3), 60, np.uint8)
    pictures = [grey if picture is None else picture for picture in frame.pictures]
    tiles = {name: resized(p, TILE_PX) for name, p in zip(CAMERAS, pictures, strict=True)}
    seg = sequence.seg(0, index) if sequence.has("seg_left") else None
    if sequence.has("depth_left"):
        tiles["depth"] = resized(label_colours.depth_picture(sequence.depth_m(0, index)), TILE_PX)
    if seg is not None:
        tiles["seg"] = resized(label_colours.seg_picture(seg), TILE_PX, exact=True)
    if sequence.has("amodal_left"):
        amodal = label_colours.amodal_picture(pictures[0], sequence.amodal(0, index), seg)
        tiles["amodal"] = resized(amodal, TILE_PX)
    return tiles


def _most_hidden_frame(sequence: StoredSequence) -> int:
    """Index of the frame with most of its targets hidden, of frames with both pictures."""
    rows, T = sequence.truth, len(TARGETS)
    visible = [rows[f"visible_fraction_{view}"].to_numpy(np.float64) for view in CAMERAS]
    present = [rows[f"amodal_{view}_px"].to_numpy(np.float64) > 0 for view in CAMERAS]
    arrived = [rows[f"arrived_{view}"].to_numpy(bool) for view in CAMERAS]
    hidden = sum(np.where(p, 1 - v, 0.0) for p, v in zip(present, visible, strict=True))
    cost = np.asarray(hidden).reshape(-1, T).sum(axis=1)
    whole = np.logical_and.reduce([*arrived, *present]).reshape(-1, T).all(axis=1)
    return int(np.where(whole, cost, -1.0).argmax())
