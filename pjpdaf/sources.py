"""Recorded footage: picture folders or videos of two views, read one frame at a time."""

from __future__ import annotations

import glob
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from pjpdaf.layouts import LAYOUTS, Layout
from pjpdaf.pairing import Pairing, in_natural_order, order_doubt, paired
from pjpdaf.picture_files import PICTURE_SUFFIXES, is_picture, read_picture
from pjpdaf.videos import Video, VideoFrame, open_video, video_frames

FOLDER_RATE_HZ = 3.0  # the thesis's frame rate, section 4.1; a folder does not say its own
VIEWS = ("left", "right")
APART_S = 0.5  # of a frame's period: views whose times differ by more are not of one moment

Warn = Callable[[str], None]


@dataclass(frozen=True)
class PictureFolder:
    """Pictures of one view, in natural order (2 before 10)."""

    path: Path
    files: tuple[Path, ...]

    @property
    def count(self) -> int:
        """Number of pictures."""
        return len(self.files)


Source = PictureFolder | Video


@dataclass(frozen=True, eq=False)
class PicturePair:
    """Both views of one moment: names (for messages) and pictures uint8 BGR, None = missing.

    time_s: since the first pair, None where the source has no times.
    """

    index: int
    names: tuple[str, str]
    pictures: tuple[np.ndarray | None, np.ndarray | None]
    time_s: float | None = None


def open_source(path: Path | str) -> Source:
    """Open a folder of pictures, a pattern such as 'pictures/left*.png', or a video file.

    Raises BenchError where there is no such file or folder, or nothing readable in it.
    """
    path = Path(path)
    kinds = ", ".join(s[1:] for s in PICTURE_SUFFIXES)
    if path.is_dir():
        files = [f for f in path.iterdir() if is_picture(f)]
        if not files:
            raise BenchError(f"{path}: no pictures in this folder ({kinds}).")
        return PictureFolder(path, in_natural_order(files))
    if path.is_file():
        if path.suffix.lower() in PICTURE_SUFFIXES:
            raise BenchError(
                f"{path}: one picture is not a sequence; give its folder, or a pattern."
            )
        return open_video(path)
    if any(c in path.name for c in "*?["):
        files = [Path(f) for f in glob.glob(str(path)) if is_picture(Path(f))]  # noqa: PTH207
        if not files:
            raise BenchError(f"{path}: no pictures match this pattern ({kinds}).")
        return PictureFolder(path, in_natural_order(files))
    raise BenchError(
        f"{path}: no such file or folder; give a folder of pictures, a pattern or a video."
    )


def picture_pairs(
    left: Path | str,
    right: Path | str | None,
    warn: Warn | None = None,
    shortest: bool = False,
    layout: Layout = "separate",
) -> Iterator[PicturePair]:
    """Pairs of two folders or two videos, in order; memory stays flat.

    Folders are paired by the whole names of their files (`pjpdaf.pairing`); a name that is in only
    one of them is a missing picture. Where the names do not agree they are paired in order, and
    must be equally long unless `shortest`. A missing or unreadable picture is named to `warn` and
    is None in its pair. layout: where both views are in each picture of `left`; right is None then.

    Raises BenchError, before the first pair, where a source cannot be read or the counts differ.
    """
    say = warn if warn is not None else _silent
    a = open_source(left)
    if layout != "separate":
        if right is not None:
            raise BenchError(f"--stereo {layout}: both views are in {a.path}; leave --right out.")
        return _joined_pairs(a, layout, say)
    if right is None:
        raise BenchError(
            f"{a.path}: is one view; give --right, or --stereo {LAYOUTS[1]} where both views are "
            "in each picture."
        )
    b = open_source(right)
    if isinstance(a, PictureFolder) and isinstance(b, PictureFolder):
        pairing = paired(a.files, b.files)
        if pairing.in_order:
            _check_counts(a, b, "pictures", shortest)
        if pairing.note and not (pairing.in_order and shortest):
            say(f"{a.path}: {pairing.note}.")
        return _folder_pairs(a, b, pairing, say)
    if isinstance(a, Video) and isinstance(b, Video):
        _check_counts(a, b, "frames", shortest)
        if a.rate_hz and b.rate_hz and abs(a.rate_hz / b.rate_hz - 1) > 0.01:
            raise BenchError(
                f"The videos' frame rates differ: {a.path} {a.rate_hz:g}/s, "
                f"{b.path} {b.rate_hz:g}/s."
            )
        return _video_pairs(a, b, say)
    raise BenchError(
        f"Left and right must be of one kind, two folders or two videos: {a.path}, {b.path}."
    )


def stereo_frames(
    left: Path | str,
    right: Path | str | None,
    rate_hz: float | None = None,
    sizes_px: tuple[tuple[int, int], tuple[int, int]] | None = None,
    warn: Warn | None = None,
    shortest: bool = False,
    layout: Layout = "separate",
) -> Iterator[StereoFrame]:
    """Stereo frames of two folders or videos (`picture_pairs`), for detector and tracker.

    rate_hz: frames per second; default the videos' own times, 3/s for folders. sizes_px: (width,
    height) per view as calibrated; default the size of each view's first picture.

    Raises BenchError naming the file and both sizes where a picture has another size.
    """
    if rate_hz is not None and not 0 < rate_hz < float("inf"):
        raise BenchError(f"The frame rate must be above 0 Hz, got {rate_hz}.")
    pairs = picture_pairs(left, right, warn, shortest, layout)
    own_times = rate_hz is None
    if rate_hz is None:
        rate_hz = own_rate_hz(left)
    return _frames(pairs, rate_hz, own_times, sizes_px)


def own_rate_hz(source: Path | str) -> float:
    """Frames a second of a video as its container says; 3/s for folders. Raises BenchError."""
    opened = open_source(source)
    return opened.rate_hz if isinstance(opened, Video) and opened.rate_hz else FOLDER_RATE_HZ


def _frames(
    pairs: Iterator[PicturePair],
    rate_hz: float,
    own_times: bool,
    sizes_px: tuple[tuple[int, int], tuple[int, int]] | None,
) -> Iterator[StereoFrame]:
    wanted: list[tuple[int, int] | None] = list(sizes_px) if sizes_px else [None, None]
    origin = ["the calibration's" if sizes_px else ""] * 2
    before_s = -1.0 / rate_hz
    for pair in pairs:
        for view, (name, picture) in enumerate(zip(pair.names, pair.pictures, strict=True)):
            if picture is None:
                continue
            size = (picture.shape[1], picture.shape[0])
            expected = wanted[view]
            if expected is None:
                wanted[view], origin[view] = size, f"that of {name}"
            elif size != expected:
                raise BenchError(
                    f"{name}: the picture is {size[0]}x{size[1]} px, expected "
                    f"{expected[0]}x{expected[1]}, {origin[view]}."
                )
        time_s = pair.index / rate_hz
        if own_times and pair.time_s is not None:
            time_s = pair.time_s
        if time_s <= before_s:  # after a frame without a time of its own
            time_s = before_s + 1.0 / rate_hz
        before_s = time_s
        yield StereoFrame(pair.index, time_s, pair.pictures)


def _silent(message: str) -> None:
    """Drop the message."""


def _check_counts(a: Source, b: Source, unit: str, shortest: bool) -> None:
    if a.count and b.count and a.count != b.count and not shortest:
        raise BenchError(
            f"Left and right differ in length: {a.path} has {a.count} {unit}, {b.path} {b.count}; "
            "where they begin at the same moment, --shortest leaves out the rest of the longer one."
        )


def _folder_pairs(
    a: PictureFolder, b: PictureFolder, pairing: Pairing, say: Warn
) -> Iterator[PicturePair]:
    for index, pair in enumerate(pairing.pairs):
        names: list[str] = []
        pictures: list[np.ndarray | None] = []
        for view, file in enumerate(pair):
            picture = read_picture(file) if file is not None else None
            partner = pair[1 - view]
            name = str(file) if file is not None else f"{(a, b)[view].path} (no picture)"
            if file is None and partner is not None:
                say(f"{VIEWS[view]}: no picture belongs to {partner}; its view counts as missing.")
            elif picture is None:
                say(f"{name}: cannot be read as a picture; it counts as missing.")
            names.append(name)
            pictures.append(picture)
        yield PicturePair(index, (names[0], names[1]), (pictures[0], pictures[1]))


def _video_pairs(a: Video, b: Video, say: Warn) -> Iterator[PicturePair]:
    told, last_s = False, 0.0
    ends: tuple[VideoFrame | None, VideoFrame | None] = (None, None)
    rows = itertools.zip_longest(video_frames(a), video_frames(b))
    for index, (left, right) in enumerate(itertools.chain(rows, [ends])):
        if left is None or right is None:
            _say_end(index, last_s, (a, b), [left is not None, right is not None], say)
            return
        last_s = left.time_s or 0.0
        names = (f"{a.path} frame {index}", f"{b.path} frame {index}")
        for name, frame in zip(names, (left, right), strict=True):
            if frame.picture is None:
                say(f"{name}: cannot be decoded; it counts as missing.")
        apart_s = abs((left.time_s or 0.0) - (right.time_s or 0.0))
        if not told and left.time_s and right.time_s and apart_s * (a.rate_hz or 30.0) > APART_S:
            told = True
            say(
                f"{names[0]}: is at {left.time_s:.3f} s, the right view's at {right.time_s:.3f} s: "
                "the videos do not run alike; the left one's times are taken."
            )
        yield PicturePair(index, names, (left.picture, right.picture), left.time_s)


def _joined_pairs(source: Source, layout: Layout, say: Warn) -> Iterator[PicturePair]:
    """Pairs of pictures that hold both views."""
    for index, (name, picture, time_s) in enumerate(_pictures_of(source, say)):
        halves: tuple[np.ndarray | None, np.ndarray | None] = (None, None)
        if picture is not None:
            side = picture.shape[1 if layout == "side-by-side" else 0]
            if side % 2:
                raise BenchError(f"{name}: is {side} px {layout}: two views need an even number.")
            half = side // 2
            if layout == "side-by-side":
                halves = (picture[:, :half].copy(), picture[:, half:].copy())
            else:
                halves = (picture[:half].copy(), picture[half:].copy())
        yield PicturePair(index, (f"{name} (left)", f"{name} (right)"), halves, time_s)


def _pictures_of(
    source: Source, say: Warn
) -> Iterator[tuple[str, np.ndarray | None, float | None]]:
    if isinstance(source, Video):
        for index, frame in enumerate(video_frames(source)):
            name = f"{source.path} frame {index}"
            if frame.picture is None:
                say(f"{name}: cannot be decoded; it counts as missing.")
            yield name, frame.picture, frame.time_s
        return
    doubt = order_doubt(source.files)
    if doubt:
        say(f"{source.path}: {doubt}.")
    for file in source.files:
        picture = read_picture(file)
        if picture is None:
            say(f"{file}: cannot be read as a picture; it counts as missing.")
        yield str(file), picture, None


def _say_end(
    index: int, last_s: float, videos: tuple[Video, Video], grabbed: list[bool], say: Warn
) -> None:
    """Name a view that ends early. index: frames read; last_s: time of the last, 0 = unknown."""
    for video, more in zip(videos, grabbed, strict=True):
        early = bool(video.count) and index < video.count
        # Of a variable rate, the container's count is only its duration times its rate.
        if early and video.rate_hz and last_s >= (video.count - 2.5) / video.rate_hz:
            early = False
        if not more and (early or any(grabbed)):
            total = f" of {video.count}" if video.count else ""
            say(f"{video.path}: ends after {index}{total} frames; both views stop here.")
