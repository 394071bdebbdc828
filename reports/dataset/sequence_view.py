"""The pictures of a sequence on the page: every layer, frame by frame, within a size."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Image
from reports.dataset import label_colours
from reports.page.packing import base64_text
from reports.pictures.encode import webp_of
from reports.pictures.overlay import canvas_of
from reports.pictures.resize import resized
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

MOST_BYTES = 25_000_000  # of all pictures as they stand in the page
VIEW_PX = 320
LOSSLESS = 101  # of OpenCV's WebP: ids must not be mixed
# Per layer: the folder that it needs, its WebP quality, whether it shows the rectified pair.
LAYERS: dict[str, tuple[str, int, bool]] = {
    "colour": ("left", 45, False),
    "clean": ("clean_left", 45, False),
    "depth": ("depth_left", 55, False),
    "seg": ("seg_left", LOSSLESS, False),
    "amodal": ("amodal_left", 50, False),
    "disparity": ("disparity_left", 55, True),
    "occlusion": ("occlusion_left", LOSSLESS, True),
    "classes": ("semantic_left", LOSSLESS, False),
    "normals": ("normals_left", 60, False),
    "flow": ("flow_forward_left", 60, False),
}
THREADS = 4  # encode while the next layer is read


@dataclass(frozen=True, eq=False)
class SequenceView:
    """A sequence on the page.

    layers: each layer's frames as WebP, both views side by side; frames: their number, which may
    be less than the sequence's.
    """

    sequence: StoredSequence
    layers: Mapping[str, tuple[bytes, ...]]
    frames: int

    @property
    def name(self) -> str:
        """Folder, label and seed, such as "seq_000000 cross, seed 3"."""
        entry = self.sequence.entry
        rung = f", {entry['rung']}" if entry.get("rung") else ""
        return f"{self.sequence.name} {entry.get('label', '')}{rung}, seed {entry.get('seed', '')}"

    @property
    def packed(self) -> dict[str, tuple[str, str]]:
        """By layer: the sizes of its pictures, and the pictures in base64."""
        return {
            layer: (" ".join(str(len(p)) for p in pictures), base64_text(b"".join(pictures)))
            for layer, pictures in self.layers.items()
        }


def sequence_views(
    sequences: Sequence[StoredSequence],
    most_bytes: int = MOST_BYTES,
    on_frame: Callable[[], None] = lambda: None,
) -> list[SequenceView]:
    """Take the first sequences that fit into a size; of the very first as many frames as fit.

    on_frame is called after each frame.
    """
    room = most_bytes
    views: list[SequenceView] = []
    with ThreadPoolExecutor(THREADS) as pool:
        for sequence in sequences:
            view, size = _view_of(sequence, room, pool, on_frame)
            if view.frames == sequence.frame_count or not views:
                views.append(view)
            if view.frames < sequence.frame_count:
                break
            room -= size
    return views


def _view_of(
    sequence: StoredSequence,
    most_bytes: int,
    pool: ThreadPoolExecutor,
    on_frame: Callable[[], None],
) -> tuple[SequenceView, int]:
    """A sequence's frames as far as they fit, at least the first, and their size [bytes]."""
    layers = [name for name, (folder, *_) in LAYERS.items() if sequence.has(folder)]
    qualities = [LAYERS[name][1] for name in layers]
    frames: list[tuple[bytes, ...]] = []
    used = 0
    for index in range(sequence.frame_count):
        webps = tuple(pool.map(webp_of, _pictures(sequence, index, layers), qualities))
        used += sum(4 * -(-len(webp) // 3) for webp in webps)
        if frames and used > most_bytes:
            break
        frames.append(webps)
        on_frame()
    columns = zip(*frames, strict=True)
    return SequenceView(sequence, dict(zip(layers, columns, strict=True)), len(frames)), used


def _pictures(sequence: StoredSequence, index: int, layers: Sequence[str]) -> Iterator[Image]:
    """Both views of a frame side by side, each VIEW_PX wide, layer by layer."""
    frame = sequence.frame(index)
    for name in layers:
        exact = LAYERS[name][1] == LOSSLESS
        views = [
            resized(_layer(sequence, index, v, name, picture), VIEW_PX, exact)
            for v, picture in enumerate(frame.pictures)
        ]
        height = max(view.shape[0] for view in views)
        yield np.hstack([np.pad(v, ((0, height - len(v)), (0, 0), (0, 0))) for v in views])


def _layer(
    sequence: StoredSequence, index: int, v: int, layer: str, picture: np.ndarray | None
) -> Image:
    """A layer of one view, (h, w, 3) BGR."""
    camera = sequence.rig.cameras[v]
    if layer == "colour":
        return canvas_of(picture, camera)
    if layer == "clean":
        return sequence.clean(v, index)
    if layer == "depth":
        return label_colours.depth_picture(sequence.depth_m(v, index))
    if layer == "seg":
        return label_colours.seg_picture(sequence.seg(v, index))
    if layer == "classes":
        return label_colours.classes_picture(sequence.classes(v, index))
    if layer == "normals":
        return label_colours.normals_picture(sequence.normals(v, index))
    if layer == "flow":
        return _flow(sequence, index, v)
    if layer == "amodal":
        seg = sequence.seg(v, index) if sequence.has(f"seg_{CAMERAS[v]}") else None
        return label_colours.amodal_picture(
            canvas_of(picture, camera), sequence.amodal(v, index), seg
        )
    matches = sequence.rectified(v, index)
    if layer == "occlusion":
        return label_colours.occlusion_picture(matches.status)
    assert matches.disparity_px is not None, "a rectified pair always has a disparity"
    return label_colours.disparity_picture(
        matches.disparity_px, label_colours.most_disparity_px(sequence.rig)
    )


def _flow(sequence: StoredSequence, index: int, v: int) -> Image:
    """Forward flow of a view; of the last frame, which has none, that back to the one before."""
    last = index == sequence.frame_count - 1
    camera = sequence.rig.cameras[v]
    if last and not index:  # a single frame
        return canvas_of(None, camera)
    flow = sequence.flow(v, index, "backward" if last else "forward")
    assert flow.places_px is not None, "flow always has places"
    return label_colours.flow_picture(flow.places_px, flow.status)
