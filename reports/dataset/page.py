"""A data set as one page that opens from disk: both views, all layers, boxes, keypoints, values."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import resources
from itertools import combinations
from typing import Any

import cv2
import jinja2
import numpy as np
from markupsafe import Markup

from pjpdaf.targets import TARGETS
from reports.dataset import colours as look
from reports.dataset.svg_bars import histogram_svg, words_of
from reports.pictures.overlay import Image, canvas_of
from reports.summary.tables import LABELS as WORDS
from sim.dataset.files.layout import EVENTS
from sim.dataset.files.reading import read_json
from sim.dataset.labels.records import KEYPOINTS
from sim.dataset.reader import Dataset
from sim.dataset.statistics import Statistics
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

MARK = "pjpdaf-bench dataset show"
MOST_BYTES = 25_000_000  # of all pictures as they stand in the page
VIEW_PX = 320
LOSSLESS = 101  # of OpenCV's WebP: ids are not to be mixed
# Layer: the folder that it needs, its WebP quality, whether it is of the rectified pair.
LAYERS: dict[str, tuple[str, int, bool]] = {
    "colour": ("left", 45, False),
    "clean": ("clean_left", 45, False),
    "depth": ("depth_left", 55, False),
    "seg": ("seg_left", LOSSLESS, False),
    "amodal": ("amodal_left", 50, False),
    "disparity": ("disparity_left", 55, True),
    "occlusion": ("occlusion_left", LOSSLESS, True),
}
MOST_ROWS, MOST_SPANS = 40, 400  # of events beside the slider
THREADS = 4  # encode beside what is read


@dataclass(frozen=True, eq=False)
class Clip:
    """A sequence on the page. layers: of each layer the frames as WebP, both views in one; frames:
    how many of the sequence's there are.
    """

    sequence: StoredSequence
    layers: Mapping[str, tuple[bytes, ...]]
    frames: int

    @property
    def name(self) -> str:
        """Such as "seq_000000 cross, seed 3"."""
        entry = self.sequence.entry
        rung = f", {entry['rung']}" if entry.get("rung") else ""
        return f"{self.sequence.name} {entry.get('label', '')}{rung}, seed {entry.get('seed', '')}"

    @property
    def packed(self) -> dict[str, tuple[str, str]]:
        """Of each layer the sizes of its pictures, and all of them in base64."""
        return {
            layer: (" ".join(str(len(p)) for p in pictures), _base64(b"".join(pictures)))
            for layer, pictures in self.layers.items()
        }

    @property
    def data(self) -> str:
        """Its numbers, gzip and base64."""
        text = json.dumps(clip_data(self), separators=(",", ":"), allow_nan=False)
        return _base64(gzip.compress(text.encode(), 9, mtime=0))


def clips(
    sequences: Sequence[StoredSequence],
    most_bytes: int = MOST_BYTES,
    on_frame: Callable[[], None] = lambda: None,
) -> list[Clip]:
    """The first sequences that fit into this room; of the very first one what fits of it.

    on_frame is called after each frame that was looked at.
    """
    room = most_bytes
    found: list[Clip] = []
    with ThreadPoolExecutor(THREADS) as pool:
        for sequence in sequences:
            clip, size = _clip(sequence, room, pool, on_frame)
            if clip.frames == sequence.frame_count or not found:
                found.append(clip)
            if clip.frames < sequence.frame_count:
                break
            room -= size
    return found


def _clip(
    sequence: StoredSequence,
    most_bytes: int,
    pool: ThreadPoolExecutor,
    on_frame: Callable[[], None],
) -> tuple[Clip, int]:
    """A sequence's frames as far as they fit, the first one in any case, and their size."""
    layers = [name for name, (folder, *_) in LAYERS.items() if sequence.has(folder)]
    qualities = [LAYERS[name][1] for name in layers]
    frames: list[tuple[bytes, ...]] = []
    used = 0
    for index in range(sequence.frame_count):
        webps = tuple(pool.map(_webp, _pictures(sequence, index, layers), qualities))
        used += sum(4 * -(-len(webp) // 3) for webp in webps)
        if frames and used > most_bytes:
            break
        frames.append(webps)
        on_frame()
    columns = zip(*frames, strict=True)
    return Clip(sequence, dict(zip(layers, columns, strict=True)), len(frames)), used


def _pictures(sequence: StoredSequence, index: int, layers: Sequence[str]) -> Iterator[Image]:
    """Both views of a frame side by side, each VIEW_PX wide, layer by layer."""
    frame = sequence.frame(index)
    for name in layers:
        exact = LAYERS[name][1] == LOSSLESS
        views = [
            look.small(_view(sequence, index, v, name, picture), VIEW_PX, exact)
            for v, picture in enumerate(frame.pictures)
        ]
        height = max(view.shape[0] for view in views)
        yield np.hstack([np.pad(v, ((0, height - len(v)), (0, 0), (0, 0))) for v in views])


def _view(
    sequence: StoredSequence, index: int, v: int, layer: str, picture: np.ndarray | None
) -> Image:
    camera = sequence.rig.cameras[v]
    if layer == "colour":
        return canvas_of(picture, camera)
    if layer == "clean":
        return sequence.clean(v, index)
    if layer == "depth":
        return look.depth_picture(sequence.depth_m(v, index))
    if layer == "seg":
        return look.seg_picture(sequence.seg(v, index))
    if layer == "amodal":
        seg = sequence.seg(v, index) if sequence.has(f"seg_{CAMERAS[v]}") else None
        return look.amodal_picture(canvas_of(picture, camera), sequence.amodal(v, index), seg)
    matches = sequence.rectified(v, index)
    if layer == "occlusion":
        return look.occlusion_picture(matches.status)
    assert matches.disparity_px is not None, "of the rectified pair there is always a disparity"
    return look.disparity_picture(matches.disparity_px, look.most_disparity_px(sequence.rig))


def clip_data(clip: Clip) -> dict[str, Any]:
    """The numbers of a sequence as plain values: whole 0.1 mm, mm/s, 0.1 px, per mille, ms.

    Each list has an entry a frame; within it one a view and target, or a view and keypoint.
    """
    sequence, T = clip.sequence, len(TARGETS)
    rows = sequence.truth.iloc[: T * clip.frames].to_dict("records")
    frames = [rows[i : i + T] for i in range(0, len(rows), T)]
    rigs = sequence.rig.cameras
    return {
        "name": clip.name,
        "fps": sequence.fps,
        "all": sequence.frame_count,
        "size": [[camera.width_px, camera.height_px] for camera in rigs],
        "ms": [_whole(mine[0]["time_s"], 1e3) for mine in frames],
        "came": [[int(bool(mine[0][f"arrived_{view}"])) for view in CAMERAS] for mine in frames],
        "places": [[[_whole(r[f"{a}_m"], 1e4) for a in "xyz"] for r in mine] for mine in frames],
        "speeds": [[_speed(r) for r in mine] for mine in frames],
        "shown": _per_view(frames, lambda r, view: _shown(r, view)),
        "cut": _per_view(frames, lambda r, view: _whole(r[f"truncation_{view}"], 1e3)),
        "boxes": _per_view(frames, lambda r, view: _box(r, f"box_{{}}_{view}_px")),
        "wholes": _per_view(frames, lambda r, view: _box(r, f"amodal_box_{{}}_{view}_px")),
        "by": _per_view(frames, _occluders),
        "with": _per_view(
            frames, lambda r, view: [_target_words(str(o)[:40]) for o in r[f"merged_with_{view}"]]
        ),
        "points": _per_view(frames, _points),
        "events": event_rows(read_json(sequence.folder / EVENTS), clip.frames),
        "legend": [
            [_css_colour(look.instance_colour(one.id)), one.name[:60]]
            for one in sequence.instances
            if 0 <= one.id <= 255
        ],
    }


def event_rows(events: Mapping[str, Any], frames: int) -> list[dict[str, Any]]:
    """A row for each thing that happens: its kind, its words, its intervals of frames.

    What is not as `events_of` writes it is left out: the file may be a stranger's.
    """
    rows: dict[tuple[str, str], list[list[int]]] = {}
    for kind in ("merges", "ambiguous", "occlusions", "script"):
        listed = events.get(kind)
        for one in listed if isinstance(listed, list) else ():
            span = _span(one, frames)
            if span is not None:
                rows.setdefault((kind, _event_words(kind, one)), []).append(span)
    return [
        {"kind": kind, "words": words, "spans": spans[:MOST_SPANS]}
        for (kind, words), spans in list(rows.items())[:MOST_ROWS]
    ]


def _span(one: Any, frames: int) -> list[int] | None:
    if not isinstance(one, Mapping):
        return None
    first, last = one.get("first_frame"), one.get("last_frame")
    if not (isinstance(first, int) and isinstance(last, int) and 0 <= first <= last):
        return None
    return [first, min(last, frames - 1)] if first < frames else None


def _event_words(kind: str, one: Mapping[str, Any]) -> str:
    def said(key: str) -> str:
        return _target_words(str(one.get(key, "?"))[:60])

    if kind == "merges":
        targets = one.get("targets")
        pair = [str(t)[:40] for t in targets[:2]] if isinstance(targets, list) else []
        return f"{' + '.join(map(_target_words, pair))} merged, {said('view')}"
    if kind == "ambiguous":
        return "both hands one blob in both views"
    if kind == "occlusions":
        return f"{said('target')} hidden by {said('by')}, {said('view')}"
    return said("event")


def dataset_page(
    dataset: Dataset, statistics: Statistics, shown: Sequence[Clip], title: str
) -> str:
    """The page; title: what it is called."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "page/templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    layers = [name for name in LAYERS if any(name in clip.layers for clip in shown)]
    charts = [
        (f"data:image/svg+xml;base64,{_base64(histogram_svg(one).encode())}", words_of(one), one)
        for one in statistics.histograms.values()
    ]
    pairs = list(combinations(TARGETS, 2))
    return environment.get_template("dataset.html.j2").render(
        title=title,
        mark=MARK,
        statistics=statistics,
        sequences=dataset.sequences,
        clips=shown,
        layers=layers,
        rectified=[name for name in layers if LAYERS[name][2]],
        charts=charts,
        merged=statistics.merged,
        pairs=pairs,
        targets=[(target, WORDS[target]) for target in TARGETS],
        keypoints=[name for _, name in KEYPOINTS],
        licence=dataset.manifest.get("licence", ""),
        css=_text("page.css", "player.css", "dataset.css"),
        script=_text("dataset.js"),
    )


def _text(*names: str) -> Markup:
    folder = resources.files("reports") / "page" / "templates"
    return Markup("\n".join((folder / name).read_text(encoding="utf-8") for name in names))


def _per_view(frames: Sequence[Sequence[Mapping[Any, Any]]], value: Any) -> list[Any]:
    """[frame][view][target] of a function of row and view's name."""
    return [[[value(row, view) for row in mine] for view in CAMERAS] for mine in frames]


def _shown(row: Mapping[Any, Any], view: str) -> int | None:
    """Per mille; None out of the picture."""
    if not row[f"amodal_{view}_px"]:
        return None
    return _whole(row[f"visible_fraction_{view}"], 1e3)


def _box(row: Mapping[Any, Any], name: str) -> list[int] | None:
    values = [_whole(row[name.format(part)], 1) for part in ("x", "y", "width", "height")]
    return None if None in values else [v for v in values if v is not None]


def _occluders(row: Mapping[Any, Any], view: str) -> list[list[Any]]:
    """Names and per mille of the whole target, the largest first."""
    whole = max(int(row[f"amodal_{view}_px"] or 0), 1)
    listed = [(str(o["instance"])[:60], int(o["pixels"])) for o in row[f"occluded_by_{view}"]]
    listed.sort(key=lambda one: (-one[1], one[0]))
    return [[_target_words(name), round(1000 * pixels / whole)] for name, pixels in listed[:6]]


def _points(row: Mapping[Any, Any], view: str) -> list[list[int | None]]:
    """x, y [0.1 px], status of a target's keypoints."""
    places, states = row[f"keypoints_{view}_px"], row[f"keypoint_status_{view}"]
    return [
        [_whole(place[0], 10), _whole(place[1], 10), int(state)]
        for place, state in zip(places, states, strict=True)
    ]


def _speed(row: Mapping[Any, Any]) -> int | None:
    return _whole(float(np.linalg.norm([row[f"v{a}_mps"] for a in "xyz"])), 1e3)


def _whole(value: Any, scale: float) -> int | None:
    if value is None or not np.isfinite(value):
        return None
    return round(float(value) * scale)


def _target_words(name: str) -> str:
    return WORDS.get(name, name.replace("_", " "))


def _css_colour(colour: look.Colour) -> str:
    b, g, r = colour
    return f"#{r:02x}{g:02x}{b:02x}"


def _webp(picture: Image, quality: int) -> bytes:
    done, webp = cv2.imencode(".webp", picture, [cv2.IMWRITE_WEBP_QUALITY, quality])
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(webp)


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode()
