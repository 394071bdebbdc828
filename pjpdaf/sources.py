"""Recorded footage: picture folders or videos of two views, read one frame at a time."""

from __future__ import annotations

import glob
import itertools
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
VIDEO_SUFFIXES = (".avi", ".mp4", ".m4v", ".mov", ".mkv", ".webm", ".mpg", ".mpeg")
FOLDER_RATE_HZ = 3.0  # the thesis's frame rate, section 4.1; a folder does not say its own
VIEWS = ("left", "right")

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


@dataclass(frozen=True)
class Video:
    """A video of one view. count and rate_hz as in its container, 0 = unknown."""

    path: Path
    count: int
    rate_hz: float


Source = PictureFolder | Video


@dataclass(frozen=True, eq=False)
class PicturePair:
    """Both views of one moment: names (for messages) and pictures uint8 BGR, None = missing."""

    index: int
    names: tuple[str, str]
    pictures: tuple[np.ndarray | None, np.ndarray | None]


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Key that sorts 'f2' before 'f10': digits by value, text without case."""
    pieces = re.split(r"([0-9]+)", name)
    return tuple((1, int(p), "") if p.isdecimal() else (0, 0, p.lower()) for p in pieces)


def open_source(path: Path | str) -> Source:
    """Open a folder of pictures, a pattern such as 'pictures/left*.png', or a video file.

    Raises BenchError where there is no such file or folder, or nothing readable in it.
    """
    path = Path(path)
    kinds = ", ".join(s[1:] for s in PICTURE_SUFFIXES)
    if path.is_dir():
        files = [f for f in path.iterdir() if _is_picture(f)]
        if not files:
            raise BenchError(f"{path}: no pictures in this folder ({kinds}).")
        return PictureFolder(path, _sorted(files))
    if path.is_file():
        return _open_video(path)
    if any(c in path.name for c in "*?["):
        files = [Path(f) for f in glob.glob(str(path)) if _is_picture(Path(f))]  # noqa: PTH207
        if not files:
            raise BenchError(f"{path}: no pictures match this pattern ({kinds}).")
        return PictureFolder(path, _sorted(files))
    raise BenchError(
        f"{path}: no such file or folder; give a folder of pictures, a pattern or a video."
    )


def _is_picture(file: Path) -> bool:
    hidden = file.name.startswith(".")
    return not hidden and file.suffix.lower() in PICTURE_SUFFIXES and file.is_file()


def _sorted(files: list[Path]) -> tuple[Path, ...]:
    return tuple(sorted(files, key=lambda f: (natural_key(f.name), f.name)))


def _open_video(path: Path) -> Video:
    if path.suffix.lower() in PICTURE_SUFFIXES:
        raise BenchError(f"{path}: one picture is not a sequence; give its folder, or a pattern.")
    capture = cv2.VideoCapture(str(path))
    try:
        if not capture.isOpened():
            raise BenchError(
                f"{path}: not a video that can be read here; convert it to one of "
                f"{', '.join(s[1:] for s in VIDEO_SUFFIXES)}, or give a folder of pictures."
            )
        count = capture.get(cv2.CAP_PROP_FRAME_COUNT)
        rate = capture.get(cv2.CAP_PROP_FPS)
    finally:
        capture.release()
    # Streams and some containers report garbage (negative, 1e18) for values they do not know.
    return Video(path, int(count) if 0 < count < 1e8 else 0, float(rate) if 0 < rate < 1e4 else 0.0)


def read_picture(file: Path) -> np.ndarray | None:
    """Picture uint8 BGR (h, w, 3) as the sensor gave it (no EXIF rotation), None if unreadable."""
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(
        0
    )  # the caller names the file; OpenCV would print five lines about it
    try:
        data = np.fromfile(file, np.uint8)  # not imread: it cannot open every path on every system
        if len(data) == 0:
            return None
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
        picture: np.ndarray | None = cv2.imdecode(data, flags)
    except (OSError, cv2.error):
        return None
    finally:
        cv2.utils.logging.setLogLevel(level)
    return picture


def picture_pairs(
    left: Path | str, right: Path | str, warn: Warn | None = None, shortest: bool = False
) -> Iterator[PicturePair]:
    """Pairs of two folders or two videos, in order; memory stays flat.

    Folders whose file names carry numbers that agree are paired by number, and a number that is in
    only one of them is a missing picture; else they are paired in order, and must be equally long
    unless `shortest`. A missing or unreadable picture is named to `warn` and is None in its pair.

    Raises BenchError, before the first pair, where a source cannot be read or the counts differ.
    """
    say = warn if warn is not None else _silent
    a, b = open_source(left), open_source(right)
    if isinstance(a, PictureFolder) and isinstance(b, PictureFolder):
        return _folder_pairs(a, b, _pairing(a, b, shortest), say)
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
    right: Path | str,
    rate_hz: float | None = None,
    sizes_px: tuple[tuple[int, int], tuple[int, int]] | None = None,
    warn: Warn | None = None,
    shortest: bool = False,
) -> Iterator[StereoFrame]:
    """Stereo frames of two folders or videos (`picture_pairs`), for detector and tracker.

    rate_hz: frames per second; default the videos' own, 3/s for folders. sizes_px: (width, height)
    per view as calibrated; default the size of each view's first picture.

    Raises BenchError naming the file and both sizes where a picture has another size.
    """
    if rate_hz is not None and not 0 < rate_hz < float("inf"):
        raise BenchError(f"The frame rate must be above 0 Hz, got {rate_hz}.")
    pairs = picture_pairs(left, right, warn, shortest)
    if rate_hz is None:
        source = open_source(left)
        rate_hz = source.rate_hz if isinstance(source, Video) and source.rate_hz else FOLDER_RATE_HZ
    return _frames(pairs, rate_hz, sizes_px)


def _frames(
    pairs: Iterator[PicturePair],
    rate_hz: float,
    sizes_px: tuple[tuple[int, int], tuple[int, int]] | None,
) -> Iterator[StereoFrame]:
    wanted: list[tuple[int, int] | None] = list(sizes_px) if sizes_px else [None, None]
    origin = ["the calibration's" if sizes_px else ""] * 2
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
        yield StereoFrame(pair.index, pair.index / rate_hz, pair.pictures)


def _silent(message: str) -> None:
    """Drop the message."""


def _check_counts(a: Source, b: Source, unit: str, shortest: bool) -> None:
    if a.count and b.count and a.count != b.count and not shortest:
        raise BenchError(
            f"Left and right differ in length: {a.path} has {a.count} {unit}, {b.path} {b.count}; "
            "a pair must have one number, or cut both to the same length."
        )


def _pairing(
    a: PictureFolder, b: PictureFolder, shortest: bool
) -> list[tuple[Path | None, Path | None]]:
    """Pair files by the last number in their names, else in order."""
    left, right = _by_number(a.files), _by_number(b.files)
    common = left.keys() & right.keys()
    union = sorted(left.keys() | right.keys())
    # Fewer in common: these are two numberings, or one view's recording is cut short.
    if union and 2 * len(common) > len(union):
        return [(left.get(i), right.get(i)) for i in union]
    _check_counts(a, b, "pictures", shortest)
    return list(zip(a.files, b.files, strict=False))


def _by_number(files: tuple[Path, ...]) -> dict[int, Path]:
    """Files by the last number in their stems; empty if a file has none, or two have the same."""
    numbers: dict[int, Path] = {}
    for file in files:
        digits = re.findall(r"[0-9]+", file.stem)
        if not digits or int(digits[-1]) in numbers:
            return {}
        numbers[int(digits[-1])] = file
    return numbers


def _folder_pairs(
    a: PictureFolder, b: PictureFolder, files: list[tuple[Path | None, Path | None]], say: Warn
) -> Iterator[PicturePair]:
    for index, pair in enumerate(files):
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
    captures = (cv2.VideoCapture(str(a.path)), cv2.VideoCapture(str(b.path)))
    try:
        for index in itertools.count():
            grabbed = [capture.grab() for capture in captures]
            if not all(grabbed):
                _say_end(index, (a, b), grabbed, say)
                return
            names: list[str] = []
            pictures: list[np.ndarray | None] = []
            for video, capture in zip((a, b), captures, strict=True):
                read, picture = capture.retrieve()
                name = f"{video.path} frame {index}"
                if not read:
                    say(f"{name}: cannot be decoded; it counts as missing.")
                names.append(name)
                pictures.append(picture if read else None)
            yield PicturePair(index, (names[0], names[1]), (pictures[0], pictures[1]))
    finally:
        for capture in captures:
            capture.release()


def _say_end(index: int, videos: tuple[Video, Video], grabbed: list[bool], say: Warn) -> None:
    for video, more in zip(videos, grabbed, strict=True):
        early = bool(video.count) and index < video.count
        if not more and (early or any(grabbed)):
            total = f" of {video.count}" if video.count else ""
            say(f"{video.path}: ends after {index}{total} frames; both views stop here.")
