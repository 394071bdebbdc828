"""A data set on one sheet: a row per sequence, some of its frames with their labels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pjpdaf.arrays import Image
from pjpdaf.targets import TARGETS
from reports.dataset import label_colours
from reports.pictures.contact_sheet import GAP_PX
from reports.pictures.overlay import BLACK, STRIP, WHITE, canvas_of, draw_text
from reports.pictures.resize import resized
from reports.pictures.truth_overlay import draw_outlines
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

TILE_PX, HEAD_PX, NAME_PX = 232, 26, 24
TEXT = 0.45
LAYERS = ("depth", "seg", "disparity")  # beside the colour, where they were written


def dataset_sheet(rows: Sequence[tuple[StoredSequence, Sequence[int]]]) -> Image:
    """Lay out sequences with the frames to show (h, w, 3) BGR.

    A frame is the left view with the visible skin outlined (not without ids), its depth (red near,
    blue far), ids and disparity.
    """
    layers = [name for name in LAYERS if any(sequence.has(f"{name}_left") for sequence, _ in rows)]
    frames = max(len(chosen) for _, chosen in rows)
    columns = ["left", *layers] * frames
    width = GAP_PX + len(columns) * (TILE_PX + GAP_PX)
    head = _heads(columns, width)
    return np.vstack([head, *(_row(sequence, chosen, layers, width) for sequence, chosen in rows)])


def _heads(columns: Sequence[str], width: int) -> Image:
    strip = np.full((HEAD_PX, width, 3), STRIP, np.uint8)
    for i, name in enumerate(columns):
        draw_text(strip, name, (GAP_PX + i * (TILE_PX + GAP_PX), 18), WHITE, TEXT)
    return strip


def _row(
    sequence: StoredSequence, chosen: Sequence[int], layers: Sequence[str], width: int
) -> Image:
    tiles = [tile for index in chosen for tile in _tiles(sequence, index, layers)]
    height = tiles[0].shape[0]
    row = np.full((NAME_PX + height + GAP_PX, width, 3), STRIP, np.uint8)
    entry = sequence.entry
    rung = f", {entry['rung']}" if entry.get("rung") else ""
    title = f"{sequence.name}: {entry.get('label', '')}{rung}, seed {entry.get('seed', '')}"
    draw_text(row, _ascii(title), (GAP_PX, 17), WHITE, TEXT)
    for i, tile in enumerate(tiles):
        x = GAP_PX + i * (TILE_PX + GAP_PX)
        row[NAME_PX : NAME_PX + height, x : x + TILE_PX] = tile
    return row


def _tiles(sequence: StoredSequence, index: int, layers: Sequence[str]) -> list[Image]:
    picture = sequence.frame(index).pictures[0]
    canvas = resized(canvas_of(picture, sequence.rig.left), TILE_PX)
    if picture is not None and sequence.has(f"seg_{CAMERAS[0]}"):
        seg = resized(sequence.seg(0, index), TILE_PX, exact=True)
        labels = np.where((seg >= 1) & (seg <= len(TARGETS)), seg, 0).astype(np.int8) - 1
        draw_outlines(canvas, labels, thickness_px=1, halo=False)
    draw_text(canvas, f"frame {index}", (6, 17), WHITE, TEXT)
    return [canvas, *(_layer(sequence, index, name) for name in layers)]


def _layer(sequence: StoredSequence, index: int, name: str) -> Image:
    camera = sequence.rig.left
    if not sequence.has(f"{name}_left"):
        blank = np.full((camera.height_px, camera.width_px, 3), BLACK, np.uint8)
        return resized(blank, TILE_PX)
    if name == "depth":
        return resized(label_colours.depth_picture(sequence.depth_m(0, index)), TILE_PX)
    if name == "seg":
        return resized(label_colours.seg_picture(sequence.seg(0, index)), TILE_PX, exact=True)
    matches = sequence.rectified(0, index)
    assert matches.disparity_px is not None, "a rectified pair always has a disparity"
    most_px = label_colours.most_disparity_px(sequence.rig)
    return resized(label_colours.disparity_picture(matches.disparity_px, most_px), TILE_PX)


def _ascii(text: str) -> str:
    """Keep the characters that the drawn font has."""
    return text.encode("ascii", "replace").decode()[:160]
